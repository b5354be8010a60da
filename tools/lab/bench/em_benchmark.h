// SPDX-License-Identifier: Apache-2.0
// EM kernels against the C++ yardstick, in turns (A B A B ...) on the same samples and starts.
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
  int threads = 2;        // of the yardstick, and of a processor that is the device; 0: of each level the fastest
  std::string device;     // as Device::open() has it
  bool yardstick = true;  // false: the kernels alone
  std::optional<Instructions> instructions;  // of both; nullopt: the widest that the processor has
};

/// Milliseconds of both, a level, and their ratio; the sum over levels; the mean difference of results.
nlohmann::ordered_json run_em_benchmark(const EmBenchmarkOptions& options, Progress* progress);

ResultView view_em(const nlohmann::ordered_json& result);

}  // namespace multum::bench
