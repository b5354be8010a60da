// SPDX-License-Identifier: Apache-2.0
// Measures texture filters on baked maps: errors of pictures, flicker between frames and frame times by taps, level
// bias
// and number of lobes, next to other methods. The source of docs/evidence/FILTER.md.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct FilterBenchmarkOptions {
  std::string maps;  // folder of normal maps; empty: the generated four quarters
  std::vector<int> lobe_counts = {4, 6};
  int width = 320, height = 240;  // of the pictures for errors; flicker has half of each
  int map_size = 256;             // side of the four quarters
  int maps_max = 1000;
  // Noise of reference pictures, relative L1. Blended references may have twice as much, references for flicker three
  // times as much.
  double noise_max = 0.005;
  std::string device;  // that bakes
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  std::string folder;  // for temporary bakes; empty: the system's temporary folder
};

/// For each map and setting, returns the relative L1 error of the picture against the reference (finest texels as
/// facets, and blended). For every fourth map, adds flicker over a zoom, a pan and a turn. For the first maps, adds
/// processor milliseconds per frame, over all threads of a software GL.
nlohmann::ordered_json run_filter_benchmark(const FilterBenchmarkOptions& options, Progress* progress);

ResultView view_filters(const nlohmann::ordered_json& result);  // documents/filter_view.cpp

}  // namespace multum::bench
