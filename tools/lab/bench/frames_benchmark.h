// SPDX-License-Identifier: Apache-2.0
// Measures the frame times of baked maps with lobes, moments and harmonics, and of averaged normals with Toksvig's
// rule. The plane extends to the horizon, and is drawn with and without anisotropic filtering.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct FramesBenchmarkOptions {
  int size = 1024;  // side of the map, an even number
  int width = 1920, height = 1080;
  int repetitions = 7;  // number of runs per picture; runs of different pictures alternate
  std::string device;   // device that runs the bakes
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  std::string folder;  // folder for files; the system's temporary folder if empty
};

/// Returns the frame times in milliseconds by the driver's timer, and the texture sizes in bytes. Also returns the
/// ratio of each time to the time of the frame with Toksvig's rule in the same turn.
nlohmann::ordered_json run_frames_benchmark(const FramesBenchmarkOptions& options, Progress* progress);

ResultView view_frames(const nlohmann::ordered_json& result);

}  // namespace multum::bench
