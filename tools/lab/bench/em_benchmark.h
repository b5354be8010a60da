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
  int size = 512;  // side of the map, a power of two from 64 to 4096
  int lobes = 6;   // number of lobes: 4, 6 or 8
  int iterations = 10;
  int repetitions = 7;
  int threads = 2;        // threads of the yardstick and of a processor device; the fastest number per level if 0
  std::string device;     // name of a device, as in Device::open()
  bool yardstick = true;  // whether to run the yardstick too
  std::optional<Instructions> instructions;  // instructions that both programs use; the processor's widest if nullopt
};

/// Returns milliseconds of both programs per level, their ratios, the sums over levels, and the mean difference
/// between the results.
nlohmann::ordered_json run_em_benchmark(const EmBenchmarkOptions& options, Progress* progress);

ResultView view_em(const nlohmann::ordered_json& result);

}  // namespace multum::bench
