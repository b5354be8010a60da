// SPDX-License-Identifier: Apache-2.0
// A measured BRDF in factors (Han et al. 2007, section 4): rho(theta_h, theta_d) = k_d / pi + f(theta_h) g(theta_d).
// k_d and f have one value per channel. theta_h is the angle between half vector and normal. theta_d is the angle
// between half vector and light.
#pragma once

#include <numbers>
#include <string>
#include <vector>

#include <glm/vec3.hpp>

namespace multum {

constexpr double kHalfPi = 0.5 * std::numbers::pi;
/// Entry i is for theta_h = (pi / 2) (i / (count - 1))^2. This spacing resolves narrow highlights.
constexpr int kFacetTableSize = 90;
/// Entry i is for theta_d = (pi / 2) i / (count - 1).
constexpr int kDifferenceTableSize = 19;

struct MeasuredBrdf {
  std::string name;
  glm::dvec3 diffuse;               // k_d: albedo
  std::vector<glm::dvec3> facets;   // f at kFacetTableSize angles
  std::vector<double> differences;  // g at kDifferenceTableSize angles, with a mean of 1
  double relative_error;            // error of the factors: relative L1 of rho times its cosine
};

/// Returns f for e = 1 - n.h, interpolated linearly in the index of the table.
glm::dvec3 measured_facets(const MeasuredBrdf& brdf, double e);
double measured_differences(const MeasuredBrdf& brdf, double v_h);

}  // namespace multum
