// SPDX-License-Identifier: Apache-2.0
// Runs the solver of texture inference and Eigen's solver alternately with the same systems (plane_views.h), and
// compares them. There are no regularisers and no texels at bounds, so both solvers take the same steps. Also measures
// the figures on which the solver's choices are based. These figures are the times of its products, the numbers of
// iterations with and without preconditioner and starting value, and the cases in which A^T A saves time.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "host/foundation/base/progress.h"
#include "tools/lab/bench/documents/result_view.h"

namespace multum::bench {

struct InferenceBenchmarkOptions {
  int size = 512;       // side of the texture, a power of two from 32 to 2048
  int views = 8;        // number of views in the largest stack, 1 to 64
  int iterations = 20;  // iterations per timed solve, at least 4
  int repetitions = 7;  // number of pairs of runs
  int threads = 2;
  std::string device;  // name of a device, as for Device::open()
};

/// Returns the milliseconds per iteration of both solvers, their ratio, and the difference between their results. Also
/// returns the results for products, for iteration counts, and for the forms of the matrix.
nlohmann::ordered_json run_inference_benchmark(const InferenceBenchmarkOptions& options, Progress* progress);

ResultView view_inference(const nlohmann::ordered_json& result);

}  // namespace multum::bench
