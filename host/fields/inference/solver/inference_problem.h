// SPDX-License-Identifier: Apache-2.0
// Defines the input of texture inference (host/fields/inference/solver/texture_inference.h), which consists of the
// views of a texture and the settings.
#pragma once

#include <vector>

#include "host/fields/inferred/filter_matrix.h"

namespace multum {

enum class InferenceForm {
  kAuto,    // chosen from the number of entries (texture_system.cpp)
  kMatrix,  // products with A and its transpose, eq. (2)
  kNormal,  // products with A^T A, eq. (3)
};

struct InferenceSettings {
  double pyramid_weight = 0.1;       // epsilon_f, >= 0
  double range_weight = 0.0;         // epsilon_b, >= 0
  double gradient_tolerance = 1e-3;  // stop when the projected gradient falls below this share of its value at x = 0
  // A Newton step ends when its gradient falls below this share of the first gradient, [0, 1).
  double step_tolerance = 0.03;
  int iteration_max = 400;   // conjugate gradient iterations of all Newton steps together
  int newton_max = 12;       // most Newton steps
  bool precondition = true;  // precondition with the diagonal
  InferenceForm form = InferenceForm::kAuto;
};

/// One picture's part of a system. The matrix must outlive the system's construction.
struct InferenceView {
  const FilterMatrix* matrix;
  std::vector<float> row_weights;  // one per row of the matrix, >= 0; 0 leaves the row out
};

}  // namespace multum
