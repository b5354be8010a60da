// SPDX-License-Identifier: Apache-2.0
// Times whole programs, file to file: `multum bake` against `maketx --bumpslopes` on one map, in turns (A B A B ...).
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
  int size = 4096;                           // map side, even
  int lobes = 4;                             // 1..8
  int repetitions = 5;                       // pairs of runs
  int threads = 0;                           // of both programs; 0: all cores
  std::string folder;                        // where files go; empty: the system's folder for temporary files
  std::vector<std::string> bake_options;     // more options of `multum bake`
  std::optional<Instructions> instructions;  // of the kernels; nullopt: the widest that the processor has
};

/// Each program runs once untimed first: kernels get compiled, files into the page cache. Throws Error(kVerification)
/// when two runs of multum give different pixels.
nlohmann::ordered_json run_bake_benchmark(const BakeBenchmarkOptions& options, Progress* progress);

ResultView view_bake(const nlohmann::ordered_json& result);

}  // namespace multum::bench
