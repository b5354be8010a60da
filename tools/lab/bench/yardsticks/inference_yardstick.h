// SPDX-License-Identifier: Apache-2.0
// The yardstick for texture inference. It uses Eigen's conjugate gradient method for least squares in single precision,
// with its diagonal preconditioner. It is compiled for this machine and with OpenMP.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/fields/inference/solver/texture_system.h"

namespace multum::bench {

enum class YardstickForm {
  kRowMajor,      // LeastSquaresConjugateGradient with one solve per colour; A gathers, and A^T scatters
  kColumnMajor,   // like kRowMajor, but A scatters, and A^T gathers
  kThreeColumns,  // the same iteration, written with Eigen's products for three columns; A and A^T both gather
};

struct YardstickWay {
  YardstickForm form;
  int threads;
};

std::string yardstick_name(const YardstickWay& way);

class InferenceYardstick {
 public:
  virtual ~InferenceYardstick() = default;
  /// `colours` contains three values per row, and `start` contains three values per texel. Runs exactly
  /// `iteration_count` iterations.
  virtual std::vector<float> solve(const std::vector<float>& colours, const std::vector<float>& start,
                                   int iteration_count) = 0;
};

std::unique_ptr<InferenceYardstick> make_inference_yardstick(const SparseRows& rows, std::size_t texel_count,
                                                             const YardstickWay& way);

}  // namespace multum::bench
