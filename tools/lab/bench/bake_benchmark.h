// SPDX-License-Identifier: Apache-2.0
// Times whole programs from input file to output file. Runs `multum bake` and `maketx --bumpslopes` alternately (A B A
// B ...) with one map.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"
#include "tools/lab/bench/measuring/instructions.h"

namespace multum::bench {

struct BakeBenchmarkOptions {
  int size = 4096;                           // side of the map, an even number
  int lobes = 4;                             // number of lobes, 1 to 8
  int repetitions = 5;                       // number of pairs of runs
  int threads = 0;                           // threads of both programs; all cores if 0
  std::string folder;                        // folder for files; the system's temporary folder if empty
  std::vector<std::string> bake_options;     // additional options of `multum bake`
  std::optional<Instructions> instructions;  // instructions of the kernels; the processor's widest if nullopt
};

/// First runs each program once without measuring its time, to compile kernels and to fill the page cache. Throws
/// Error(kVerification) if two runs of multum give different pixels.
nlohmann::ordered_json run_bake_benchmark(const BakeBenchmarkOptions& options, Progress* progress);

ResultView view_bake(const nlohmann::ordered_json& result);

}  // namespace multum::bench
