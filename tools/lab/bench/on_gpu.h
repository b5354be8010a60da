// SPDX-License-Identifier: Apache-2.0
// Measures a machine with a GPU within minutes, without installing anything. After every step, it rewrites one JSON
// file and one page, so that an interrupted run keeps its results. Each step is a child process, so if a driver fails,
// the table lists the failure and the run continues.
#pragma once

#include <string>

#include "host/foundation/base/progress.h"

namespace multum::bench {

struct OnGpuOptions {
  double minutes = 8.0;           // time for all steps together; steps for which no time is left are skipped
  std::string output = "on_gpu";  // the files are OUTPUT.json and OUTPUT.md
  std::string device;             // name of a device, as for Device::open(); the first GPU if empty
  bool any_device = false;        // use a processor and software GL if there is no GPU
  bool small = false;             // use maps of 128 x 128 texels and only a few runs, to try the command
  std::string folder;             // folder for maps and bakes; the system's temporary folder if empty
};

/// Returns the exit code, which is 0 if all started steps succeeded and kVerification if a check failed. Throws
/// Error(kEnvironment) without a GPU, unless `any_device` is set.
int run_on_gpu(const OnGpuOptions& options, const std::string& command, Progress* progress);

/// Makes the page from a file that run_on_gpu() wrote. If the file is invalid, throws an Error(kInput) that names the
/// file.
std::string on_gpu_page(const std::string& json_path);

}  // namespace multum::bench
