// SPDX-License-Identifier: Apache-2.0
// Directions of an environment drawn where it is bright: for pictures by brute force.
#pragma once

#include <vector>

#include "host/formats/light/environment_map.h"

namespace multum {

/// The density of a direction is the luminance of its texel (green, with the mean of the others: what matters is that
/// no light is left out) over `total`, per solid angle.
class LightSampler {
 public:
  explicit LightSampler(const EnvironmentMap& map);
  /// Of (1 - share) of the map of `a` and `share` of that of `b`, which are of one size.
  LightSampler(const LightSampler& a, const LightSampler& b, double share);
  /// Number `index` of a low-discrepancy sequence; unit, in the environment's frame.
  glm::dvec3 direction(unsigned index) const;
  double total() const { return cumulative_.back(); }  // the integral of the luminance

 private:
  int width_, height_;
  std::vector<double> cumulative_;  // over texels
};

/// What the sampler takes for a texel's luminance.
double sampled_luminance(const glm::dvec3& light);

}  // namespace multum
