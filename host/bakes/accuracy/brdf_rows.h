// SPDX-License-Identifier: Apache-2.0
// Evaluates max(0, omega . n)^s on rows of normals for several s at once, in double: Blinn-Phong without its scale,
// and Lambert as s = 1. Powers are products of lower powers: t^20, t^100 and t^500 together take 11 products.
#pragma once

#include <array>
#include <vector>

#include <glm/vec3.hpp>

#include "host/foundation/base/vector_clones.h"

namespace multum {

/// A power as the product of two earlier powers; number 0 is t itself.
struct PowerProduct {
  int first, second;
};
struct PowerPlan {
  std::vector<PowerProduct> products;  // power 1, 2, ...
  std::vector<int> whole;              // [exponent]: number of its power; -1 if not an integer, which needs pow()
};
/// Integer exponents up to 1e6 become products; t^s then has the relative error of s roundings.
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

/// Evaluates rows of normals whose lengths contain a BRDF's width (host/formats/image/material_maps.h): densities
/// towards `omega` of the vMF lobe of each normal. For Lambert, returns max(0, omega . n) of the unit normal, on which
/// diffuse light depends.
void evaluate_shortened(const glm::dvec3& omega, bool is_lambert, const std::array<const float*, 3>& normals, int count,
                        double* values);

}  // namespace multum
