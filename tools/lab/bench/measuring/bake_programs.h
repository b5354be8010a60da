// SPDX-License-Identifier: Apache-2.0
// Makes the commands for benchmarks of whole bakes. The multum program is in the folder of this program, and maketx is
// found through PATH.
#pragma once

#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct BakeCommandOptions {
  int lobes = 4;                      // number of lobes; if 0, no option for lobes is passed
  int threads = 0;                    // number of threads; all cores if 0, the default of both programs
  std::string report;                 // JSON file that the bake writes; if empty, no file is written
  std::vector<std::string> appended;  // additional options of `multum bake`
};

/// Finds a program in the folder of this program, or a test in a folder of the archive below it (tools/bundle). If
/// there is none, throws an Error(kEnvironment) that names the folder.
std::string neighbouring_program(const std::string& name);

/// Returns the command that bakes the four-quarter map to a file, with --quiet.
std::vector<std::string> multum_bake_command(const std::string& map, const std::string& output,
                                             const BakeCommandOptions& options);

/// Returns the OpenCL device that a bake's report names. The benchmark itself opens no device, because a driver needs
/// memory and this process must stay small (measured_program.h).
std::string device_of_report(const std::string& path);

/// Returns the command that converts the same map to slopes and their squares (LEAN mapping). maketx cannot keep more
/// information about a normal map.
std::vector<std::string> maketx_command(const std::string& map, const std::string& output, int threads);

/// Returns the version of maketx, such as "2.4.7.1". Throws Error(kEnvironment) that names maketx's package if maketx
/// is missing.
std::string maketx_version();

/// Makes the four-quarter map as a 16-bit PNG, PREFIX_normal.png, and returns its name. The map is made by a process of
/// `multum testmap`, so that its memory does not count for this process.
std::string make_map_file(const std::string& prefix, int size, int seed, Progress* progress);
/// The same with the default seed, as map_normal.png in `folder`.
std::string make_map_file(const std::string& folder, int size, Progress* progress);

}  // namespace multum::bench
