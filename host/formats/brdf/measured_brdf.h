// SPDX-License-Identifier: Apache-2.0
// A measured BRDF in factors (Han et al. 2007, section 4): rho(theta_h, theta_d) = k_d / pi + f(theta_h) g(theta_d),
// k_d and f a channel each. theta_h: half vector and normal; theta_d: half vector and light.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace multum {

constexpr double kHalfPi = 0.5 * std::numbers::pi;
/// theta_h of entry i is (pi / 2) (i / (count - 1))^2: fine where highlights are narrow.
constexpr int kFacetTableSize = 90;
/// theta_d of entry i is (pi / 2) i / (count - 1).
constexpr int kDifferenceTableSize = 19;

struct MeasuredBrdf {
  std::string name;
  glm::dvec3 diffuse;               // k_d: albedo
  std::vector<glm::dvec3> facets;   // f of kFacetTableSize angles
  std::vector<double> differences;  // g of kDifferenceTableSize angles, 1 on average
  double relative_error;            // of the factors, relative L1 of rho times its cosine
};

/// f between the entries, linearly in the table's index; e = 1 - n.h.
glm::dvec3 measured_facets(const MeasuredBrdf& brdf, double e);
double measured_differences(const MeasuredBrdf& brdf, double v_h);

}  // namespace multum
