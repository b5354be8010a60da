// SPDX-License-Identifier: Apache-2.0
// Runs the EM kernels and the C++ yardstick alternately (A B A B ...) with the same samples and the same starting
// lobes, and compares their times.
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
  int threads = 2;        // threads of the yardstick and of a processor device; if 0, the fastest number for each level
                          // is used
  std::string device;     // name of a device, as for Device::open()
  bool yardstick = true;  // whether to run the yardstick too
  std::optional<Instructions> instructions;  // instructions that both programs use; the processor's widest if nullopt
};

/// For each level, returns the milliseconds of both programs, their ratio and the mean difference between their
/// results. Also returns sums over the levels.
nlohmann::ordered_json run_em_benchmark(const EmBenchmarkOptions& options, Progress* progress);

ResultView view_em(const nlohmann::ordered_json& result);

}  // namespace multum::bench
