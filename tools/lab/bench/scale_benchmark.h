// SPDX-License-Identifier: Apache-2.0
// Measures how the costs of `multum bake` grow with the map: sizes double, and each run is a process.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct ScaleBenchmarkOptions {
  int size_min = 512;                     // map side, even
  int size_max = 4096;                    // sizes double up to this size
  int lobes = 4;                          // 1..8
  int repetitions = 3;                    // runs a size
  int threads = 0;                        // 0: all cores
  std::string folder;                     // for files; empty: the system's temporary folder
  std::vector<std::string> bake_options;  // more options of `multum bake`
};

nlohmann::ordered_json run_scale_benchmark(const ScaleBenchmarkOptions& options, Progress* progress);

ResultView view_scale(const nlohmann::ordered_json& result);

}  // namespace multum::bench
