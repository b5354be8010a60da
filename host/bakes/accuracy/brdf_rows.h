// SPDX-License-Identifier: Apache-2.0
// Evaluates max(0, omega . n)^s on rows of normals, for several s at once: Blinn-Phong without its scale, and Lambert
// as s = 1. In double. All powers are reached by multiplying powers at hand: t^20, t^100 and t^500 take 11 products
// together.
#pragma once

#include <array>
#include <vector>

#include <glm/vec3.hpp>

#include "host/foundation/base/vector_clones.h"

namespace multum {

/// A power as the product of two earlier ones; number 0 is t itself.
struct PowerProduct {
  int first, second;
};
struct PowerPlan {
  std::vector<PowerProduct> products;  // power 1, 2, ...
  std::vector<int> whole;              // [exponent]: its power, -1 for one that is no whole number and takes pow()
};
/// Whole exponents up to 1e6 are products; the relative error of t^s is that of s roundings.
PowerPlan plan_powers(const std::vector<double>& exponents);

class BrdfRows {
 public:
  BrdfRows(const glm::dvec3& omega, const std::vector<double>& exponents);
  /// Writes rows[exponent][0..count). Not from two threads at once.
  void evaluate(const std::array<const float*, 3>& normals, int count, const std::vector<double*>& rows);

 private:
  glm::dvec3 omega_;
  std::vector<double> exponents_;
  PowerPlan plan_;
  AlignedRow powers_;  // [power][column of a block]
};

/// Evaluates rows of normals that a BRDF's width has shortened (host/formats/image/material_maps.h): the vMF lobe of
/// each normal, as densities towards `omega`; or max(0, omega . n) of the normal alone, which diffuse light depends on.
void evaluate_shortened(const glm::dvec3& omega, bool is_lambert, const std::array<const float*, 3>& normals, int count,
                        double* values);

}  // namespace multum
