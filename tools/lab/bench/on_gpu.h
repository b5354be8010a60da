// SPDX-License-Identifier: Apache-2.0
// Measures everything that is worth measuring on a machine with a GPU, in minutes and without installing anything: one
// JSON file and one page, written anew after every step, so that a run that is cut short keeps what it has. Each step
// is a child process: what a driver cannot do is a line of the table, not the end.
#pragma once

#include <string>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct OnGpuOptions {
  double minutes = 8.0;           // all steps together; what does not fit any more is left out
  std::string output = "on_gpu";  // OUTPUT.json and OUTPUT.md are written
  std::string device;             // as Device::open() has it; empty: the first GPU
  bool any_device = false;        // take a processor, and GL in software, where there is no GPU
  bool small = false;             // maps of 128 and fewer runs, to try the command itself
  std::string folder;             // where maps and bakes go; empty: the system's folder for temporary files
};

/// Returns the exit code: 0 when every step that was begun ended well, kVerification where a check failed. Throws
/// Error(kEnvironment) without a GPU, unless any device will do.
int run_on_gpu(const OnGpuOptions& options, const std::string& command, Progress* progress);

/// The page of a file that run_on_gpu() wrote. Throws Error(kInput) that names the file.
std::string on_gpu_page(const std::string& json_path);

}  // namespace multum::bench
