// SPDX-License-Identifier: Apache-2.0
// Measures what the texture filter makes of baked maps: errors of pictures, flicker between frames and frame times over
// taps, level bias and number of lobes, with what users have today beside it. docs/evidence/FILTER.md is made of it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "runtime_gl/context/headless_context.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct FilterBenchmarkOptions {
  std::string maps;  // folder of normal maps; empty: the four quarters that multum makes
  std::vector<int> lobe_counts = {4, 6};
  int width = 320, height = 240;  // of pictures that errors are measured on; flicker: half of each
  int map_size = 256;             // of the quarters
  int maps_max = 1000;
  // Of reference pictures, relative L1; blended ones have twice as much, those of flicker three times.
  double noise_max = 0.005;
  std::string device;  // that bakes
  gl::ContextBackend context = gl::ContextBackend::kAuto;
  std::string folder;  // where bakes go for the time being; empty: the system's folder for temporary files
};

/// Of each map and setting: relative L1 of the picture against the reference (finest texels as facets, and blended),
/// of every fourth map flicker over a zoom, a pan and a turn, of the first ones processor milliseconds of a frame,
/// which a software GL spends on all of its threads.
nlohmann::ordered_json run_filter_benchmark(const FilterBenchmarkOptions& options, Progress* progress);

ResultView view_filters(const nlohmann::ordered_json& result);  // documents/filter_view.cpp

}  // namespace multum::bench
