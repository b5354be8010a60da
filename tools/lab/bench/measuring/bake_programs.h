// SPDX-License-Identifier: Apache-2.0
// The commands that the benchmarks of whole bakes run: multum from this program's own folder, maketx from PATH.
#pragma once

#include <string>
#include <vector>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct BakeCommandOptions {
  int lobes = 4;                      // 0: says nothing of lobes
  int threads = 0;                    // 0: all cores, as both programs do untold
  std::string report;                 // JSON file that the bake writes; empty: none
  std::vector<std::string> appended;  // more options of `multum bake`
};

/// A program from the folder of this one, or a test of the archive's below it (tools/bundle). Throws
/// Error(kEnvironment) that names the folder.
std::string neighbouring_program(const std::string& name);

/// Of the four-quarter map, to a baked file. Quiet, since nobody reads it.
std::vector<std::string> multum_bake_command(const std::string& map, const std::string& output,
                                             const BakeCommandOptions& options);

/// The OpenCL device that a bake's report names. The benchmark itself opens none: a driver takes memory, and this
/// process must stay small (measured_program.h).
std::string device_of_report(const std::string& path);

/// The same map to slopes and their squares (LEAN mapping), the most that maketx keeps of a normal map.
std::vector<std::string> maketx_command(const std::string& map, const std::string& output, int threads);

/// "2.4.7.1". Throws Error(kEnvironment) that says where maketx comes from when it is missing.
std::string maketx_version();

/// Makes the four-quarter map as a 16-bit PNG in `folder` and returns its name. `multum testmap` does it, in a process
/// of its own, whose memory must not count as that of this process.
std::string make_map_file(const std::string& folder, int size, Progress* progress);

}  // namespace multum::bench
