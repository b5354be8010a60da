// SPDX-License-Identifier: Apache-2.0
// Times bakes of many small maps. One process of `multum bake` bakes all of them, and one process of `maketx
// --bumpslopes` per map converts them, alternately (A B A B ...).
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"
#include "tools/lab/bench/measuring/instructions.h"

namespace multum::bench {

struct BatchBenchmarkOptions {
  int size_min = 128;                        // side of the smallest maps, an even number
  int size_max = 1024;                       // each size is twice the previous size, up to this size
  int count = 16;                            // number of maps per size
  int lobes = 4;                             // number of lobes, 1 to 8
  int repetitions = 5;                       // number of pairs of runs per size
  int threads = 0;                           // threads of both programs; all cores if 0
  std::string folder;                        // folder for files; the system's temporary folder if empty
  std::vector<std::string> bake_options;     // additional options of `multum bake`
  std::optional<Instructions> instructions;  // instructions of the kernels; the processor's widest if nullopt
};

/// For each size, first bakes one map and converts all maps without measuring the time, to compile kernels and to fill
/// the page cache. Throws Error(kVerification) if two runs of multum give different pixels.
nlohmann::ordered_json run_batch_benchmark(const BatchBenchmarkOptions& options, Progress* progress);

ResultView view_batch(const nlohmann::ordered_json& result);

}  // namespace multum::bench
