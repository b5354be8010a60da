// SPDX-License-Identifier: Apache-2.0
// Measures a machine with a GPU in minutes, without installing anything. Rewrites one JSON file and one page after
// every step, so that an interrupted run keeps its results. Each step is a child process, so a driver failure becomes
// a row of the table and does not end the run.
#pragma once

#include <string>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct OnGpuOptions {
  double minutes = 8.0;           // time for all steps together; steps that do not fit are skipped
  std::string output = "on_gpu";  // writes OUTPUT.json and OUTPUT.md
  std::string device;             // name of a device, as in Device::open(); the first GPU if empty
  bool any_device = false;        // use a processor and software GL if there is no GPU
  bool small = false;             // use maps of 128 x 128 texels and few runs, to try the command
  std::string folder;             // folder for maps and bakes; the system's temporary folder if empty
};

/// Returns the exit code, which is 0 if all started steps succeeded and kVerification if a check failed. Throws
/// Error(kEnvironment) without a GPU, unless `any_device` is set.
int run_on_gpu(const OnGpuOptions& options, const std::string& command, Progress* progress);

/// Makes the page from a file of run_on_gpu(). Throws Error(kInput) that names the file.
std::string on_gpu_page(const std::string& json_path);

}  // namespace multum::bench
