// SPDX-License-Identifier: Apache-2.0
// Evaluates max(0, omega . n)^s on rows of normals, for several s at once and in double precision. The result is
// Blinn-Phong without its scale, or Lambert if s = 1. Powers are computed as products of lower powers. For example,
// t^20, t^100 and t^500 together take 11 products.
#pragma once

#include <array>
#include <vector>

#include <glm/vec3.hpp>

#include "host/foundation/base/vector_clones.h"

namespace multum {

/// A power that is the product of two earlier powers. Power 0 is t itself.
struct PowerProduct {
  int first, second;
};
struct PowerPlan {
  std::vector<PowerProduct> products;  // power 1, 2, ...
  std::vector<int> whole;              // [exponent]: number of its power; -1 for an exponent that is not an integer and
                                       // needs pow()
};
/// Powers with integer exponents up to 1e6 are computed as products. The relative error of t^s is then at most the
/// error of s roundings.
PowerPlan plan_powers(const std::vector<double>& exponents);

class BrdfRows {
 public:
  BrdfRows(const glm::dvec3& omega, const std::vector<double>& exponents);
  /// Writes rows[exponent][0..count). Not thread-safe.
  void evaluate(const std::array<const float*, 3>& normals, int count, const std::vector<double*>& rows);

 private:
  glm::dvec3 omega_;
  std::vector<double> exponents_;
  PowerPlan plan_;
  AlignedRow powers_;  // [power][column of a block]
};

/// Evaluates the density of each normal's vMF lobe towards `omega`, for rows of normals whose lengths contain a BRDF's
/// width (host/formats/image/material_maps.h). For Lambert, returns max(0, omega . n) of the unit normal, because
/// diffuse light depends only on it.
void evaluate_shortened(const glm::dvec3& omega, bool is_lambert, const std::array<const float*, 3>& normals, int count,
                        double* values);

}  // namespace multum
