// SPDX-License-Identifier: Apache-2.0
// Splits measurements into factors: rho(theta_h, theta_d) = k_d / pi + f(theta_h) g(theta_d). k_d and f have one value
// per channel.
#pragma once

#include <string>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/measured_brdf.h"

namespace multum {

/// The means of rho over cells of theta_h and theta_d. Azimuths are averaged, because the factors do not depend on
/// them.
class BrdfCells {
 public:
  BrdfCells();
  /// Adds a sample. Angles are in radians. Samples with an angle beyond the horizon are ignored.
  void add(double theta_h, double theta_d, const glm::dvec3& rho);
  MeasuredBrdf factor(const std::string& name) const;

 private:
  std::vector<glm::dvec3> sums_;
  std::vector<double> counts_;
};

/// Computes theta_h and theta_d of two unit directions. The normal points along z.
void half_angles(const glm::dvec3& l, const glm::dvec3& v, double* theta_h, double* theta_d);

}  // namespace multum
