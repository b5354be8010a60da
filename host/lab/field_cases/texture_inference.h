// SPDX-License-Identifier: Apache-2.0
// The objective of texture inference in double precision, as host/fields/inference/solver/texture_inference.h states
// it, one colour.
#pragma once

#include <vector>

#include "host/fields/inferred/filter_matrix.h"

namespace multum::reference {

struct InferenceProblem {
  std::vector<const FilterMatrix*> matrices;
  std::vector<std::vector<float>> row_weights;  // of each matrix
  std::vector<double> pixels;                   // of all rows of all matrices
  double pyramid_weight, range_weight;          // epsilon_f, epsilon_b
};

/// f(x).
double objective(const InferenceProblem& problem, const std::vector<double>& texels);

/// Bilinear interpolation of level l + 1 at the texels of level l: (fine texel, coarse texel, weight).
struct InterpolationEntry {
  int fine, coarse;
  double weight;
};
std::vector<InterpolationEntry> interpolation(const FilterMatrix& matrix);

/// A filter matrix of random trilinear footprints, two levels each, `rows` of them, as one of a picture `rows` wide.
FilterMatrix random_matrix(int texture_width, int texture_height, WrapMode wrap, int rows, unsigned seed);

}  // namespace multum::reference
