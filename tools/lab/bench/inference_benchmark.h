// SPDX-License-Identifier: Apache-2.0
// Compares the solver of texture inference with Eigen's solver, alternately on the same systems (plane_views.h). There
// are no regularisers and no texels at bounds, so both take the same steps. Also measures the basis of the solver's
// choices: its products, iterations with and without preconditioner and start, and when A^T A pays off.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct InferenceBenchmarkOptions {
  int size = 512;       // texture side, a power of two, 32..2048
  int views = 8;        // in the largest stack, 1..64
  int iterations = 20;  // per timed solve, >= 4
  int repetitions = 7;  // pairs of runs
  int threads = 2;
  std::string device;  // as for Device::open()
};

/// Returns milliseconds per iteration of both, their ratio and the difference of their results; products; iterations;
/// forms.
nlohmann::ordered_json run_inference_benchmark(const InferenceBenchmarkOptions& options, Progress* progress);

ResultView view_inference(const nlohmann::ordered_json& result);

}  // namespace multum::bench
