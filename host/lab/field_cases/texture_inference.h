// SPDX-License-Identifier: Apache-2.0
// Computes the objective of texture inference in double precision for one colour.
// host/fields/inference/solver/texture_inference.h defines the objective.
#pragma once

#include <vector>

#include "host/fields/inferred/filter_matrix.h"

namespace multum::reference {

struct InferenceProblem {
  std::vector<const FilterMatrix*> matrices;
  std::vector<std::vector<float>> row_weights;  // [matrix][row]
  std::vector<double> pixels;                   // one value per row of each matrix
  double pyramid_weight, range_weight;          // epsilon_f, epsilon_b
};

/// Returns f(x).
double objective(const InferenceProblem& problem, const std::vector<double>& texels);

/// One entry of the matrix that interpolates level l + 1 bilinearly at the texels of level l. The entry consists of the
/// fine texel, the coarse texel and the weight.
struct InterpolationEntry {
  int fine, coarse;
  double weight;
};
std::vector<InterpolationEntry> interpolation(const FilterMatrix& matrix);

/// Makes a filter matrix with `rows` random trilinear footprints, like the matrix of a picture with `rows` pixels. Each
/// footprint covers two levels.
FilterMatrix random_matrix(int texture_width, int texture_height, WrapMode wrap, int rows, unsigned seed);

}  // namespace multum::reference
