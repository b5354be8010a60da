// SPDX-License-Identifier: Apache-2.0
// Measures how the costs of `multum bake` grow with the size of the map. Each size is twice the previous size, and each
// run is a new process.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct ScaleBenchmarkOptions {
  int size_min = 512;                     // side of the map, an even number
  int size_max = 4096;                    // each size is twice the previous size, up to this size
  int lobes = 4;                          // number of lobes, 1 to 8
  int repetitions = 3;                    // number of runs per size
  int threads = 0;                        // number of threads; all cores if 0
  std::string folder;                     // folder for files; the system's temporary folder if empty
  std::vector<std::string> bake_options;  // additional options of `multum bake`
};

nlohmann::ordered_json run_scale_benchmark(const ScaleBenchmarkOptions& options, Progress* progress);

ResultView view_scale(const nlohmann::ordered_json& result);

}  // namespace multum::bench
