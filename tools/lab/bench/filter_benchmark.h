// SPDX-License-Identifier: Apache-2.0
// Measures picture errors, flicker between frames and frame times of texture filters on baked maps and of other
// methods, for several numbers of taps, level biases and numbers of lobes. docs/evidence/FILTER.md is made from the
// results.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct FilterBenchmarkOptions {
  std::string maps;  // folder of normal maps; if empty, the generated four-quarter map is used
  std::vector<int> lobe_counts = {4, 6};
  int width = 320, height = 240;  // size of pictures for errors; pictures for flicker have half the width and height
  int map_size = 256;             // side of the four-quarter map
  int maps_max = 1000;
  // The largest noise of reference pictures, as a relative L1 error. Blended references can have twice as much noise,
  // and references for flicker three times as much.
  double noise_max = 0.005;
  std::string device;  // device that runs the bakes
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  std::string folder;  // folder for temporary bakes; the system's temporary folder if empty
};

/// For each map and setting, returns the relative L1 errors of the picture against two references. One reference treats
/// finest texels as facets, and the other blends finest texels. For every fourth map, also returns the flicker during a
/// zoom, a pan and a turn. For the first maps, also returns the processor milliseconds per frame, over all threads of a
/// software GL.
nlohmann::ordered_json run_filter_benchmark(const FilterBenchmarkOptions& options, Progress* progress);

ResultView view_filters(const nlohmann::ordered_json& result);  // defined in documents/filter_view.cpp

}  // namespace multum::bench
