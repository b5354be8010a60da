// SPDX-License-Identifier: Apache-2.0
// Times frames of baked maps as lobes, moments and harmonics, next to averaged normals with Toksvig's rule. The plane
// runs to the horizon, with and without anisotropic filtering.
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
  int repetitions = 7;  // number of runs per picture; pictures alternate
  std::string device;   // device that bakes
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  std::string folder;  // folder for files; the system's temporary folder if empty
};

/// Returns milliseconds from the driver's timer, texture sizes in bytes, and the ratio to the frame with Toksvig's rule
/// in the same turn.
nlohmann::ordered_json run_frames_benchmark(const FramesBenchmarkOptions& options, Progress* progress);

ResultView view_frames(const nlohmann::ordered_json& result);

}  // namespace multum::bench
