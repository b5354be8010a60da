// SPDX-License-Identifier: Apache-2.0
// Times a frame of a baked map, beside the averaged normal map with Toksvig's rule that users have today: lobes,
// moments and harmonics on a plane that runs to the horizon, with and without anisotropic filtering.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct FramesBenchmarkOptions {
  int size = 1024;  // map side, even
  int width = 1920, height = 1080;
  int repetitions = 7;  // of every picture, in turns
  std::string device;   // that bakes
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  std::string folder;  // where files go; empty: the system's folder for temporary files
};

/// Milliseconds by the driver's clock, texture bytes, and the ratio to Toksvig's frame of the same turn.
nlohmann::ordered_json run_frames_benchmark(const FramesBenchmarkOptions& options, Progress* progress);

ResultView view_frames(const nlohmann::ordered_json& result);

}  // namespace multum::bench
