// SPDX-License-Identifier: Apache-2.0
// Draws directions where an environment is bright, for brute-force pictures.
#pragma once

#include <vector>

#include "host/formats/light/environment_map.h"

namespace multum {

/// The density of a direction per solid angle is the luminance of its texel (sampled_luminance()), divided by `total`.
class LightSampler {
 public:
  explicit LightSampler(const EnvironmentMap& map);
  /// Samples the sum of (1 - share) times the map of `a` and `share` times the map of `b`. Both maps must have the same
  /// size.
  LightSampler(const LightSampler& a, const LightSampler& b, double share);
  /// Returns direction `index` of a low-discrepancy sequence, as a unit vector in the frame of the environment.
  glm::dvec3 direction(unsigned index) const;
  double total() const { return cumulative_.back(); }  // integral of the luminance over the sphere

 private:
  int width_, height_;
  std::vector<double> cumulative_;  // sums over texels
};

/// Returns the mean of the channels, so that light of any colour is sampled.
double sampled_luminance(const glm::dvec3& light);

}  // namespace multum
