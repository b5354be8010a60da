// SPDX-License-Identifier: Apache-2.0
// EM kernels against the C++ yardstick, in turns (A B A B ...) on the same samples and starts.
#pragma once

#include <string>

namespace multum::bench {

struct EmBenchmarkOptions {
  int size = 512;  // map side, a power of two, 64..4096
  int lobes = 6;   // 4, 6 or 8
  int iterations = 10;
  int repetitions = 7;
  int threads = 2;
  std::string json;  // file to write; empty: none
};

/// Prints a table: level, milliseconds of both (medians), ratio; the sum over levels; the largest difference of
/// results.
int run_em_benchmark(const EmBenchmarkOptions& options);

}  // namespace multum::bench
