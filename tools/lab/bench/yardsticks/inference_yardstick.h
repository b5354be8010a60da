// SPDX-License-Identifier: Apache-2.0
// The yardstick of texture inference: Eigen's conjugate gradient for least squares, in single precision, with its
// preconditioner of the diagonal, compiled for the machine at hand and with OpenMP.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/fields/inference/solver/texture_system.h"

namespace multum::bench {

enum class YardstickForm {
  kRowMajor,      // LeastSquaresConjugateGradient, a solve for each of three colours: A gathers, A^T scatters
  kColumnMajor,   // the same: A scatters, A^T gathers
  kThreeColumns,  // its iteration written with Eigen's products on three columns at once; A and A^T both gather
};

struct YardstickWay {
  YardstickForm form;
  int threads;
};

std::string yardstick_name(const YardstickWay& way);

class InferenceYardstick {
 public:
  virtual ~InferenceYardstick() = default;
  /// `colours`: three a row; `start`: three a texel. Takes exactly `iteration_count` iterations.
  virtual std::vector<float> solve(const std::vector<float>& colours, const std::vector<float>& start,
                                   int iteration_count) = 0;
};

std::unique_ptr<InferenceYardstick> make_inference_yardstick(const SparseRows& rows, std::size_t texel_count,
                                                             const YardstickWay& way);

}  // namespace multum::bench
