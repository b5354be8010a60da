// SPDX-License-Identifier: Apache-2.0
// Compares the EM kernels with the C++ yardstick, alternately (A B A B ...), on the same samples and starts.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"
#include "tools/lab/bench/measuring/instructions.h"

namespace multum::bench {

struct EmBenchmarkOptions {
  int size = 512;  // map side, a power of two, 64..4096
  int lobes = 6;   // 4, 6 or 8
  int iterations = 10;
  int repetitions = 7;
  int threads = 2;        // for the yardstick, and for a processor as device; 0: the fastest number per level
  std::string device;     // as for Device::open()
  bool yardstick = true;  // false: only the kernels
  std::optional<Instructions> instructions;  // for both; nullopt: the widest of the processor
};

/// Returns milliseconds of both per level, their ratios, the sums over levels, and the mean difference of results.
nlohmann::ordered_json run_em_benchmark(const EmBenchmarkOptions& options, Progress* progress);

ResultView view_em(const nlohmann::ordered_json& result);

}  // namespace multum::bench
