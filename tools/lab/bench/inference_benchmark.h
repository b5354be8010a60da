// SPDX-License-Identifier: Apache-2.0
// Texture inference's solver against Eigen's, in turns on the same systems (plane_views.h), without regularisers and
// where no bound is met: then both take the same steps. And what the solver's choices rest on: the products it is made
// of, iterations with and without its preconditioner and start, and where A^T A is worth its entries.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct InferenceBenchmarkOptions {
  int size = 512;       // texture side, a power of two, 32..2048
  int views = 8;        // of the largest stack, 1..64
  int iterations = 20;  // of a timed solve, >= 4
  int repetitions = 7;  // pairs of runs
  int threads = 2;
  std::string device;  // as Device::open() has it
};

/// Milliseconds an iteration of both, their ratio and the difference of what they find; products; iterations; forms.
nlohmann::ordered_json run_inference_benchmark(const InferenceBenchmarkOptions& options, Progress* progress);

ResultView view_inference(const nlohmann::ordered_json& result);

}  // namespace multum::bench
