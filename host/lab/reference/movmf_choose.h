// SPDX-License-Identifier: Apache-2.0
// Gives each of a texel's four normals to a lobe, in double and by trying every way: the oracle of
// kernels/movmf_choose.cl, which says what is minimised. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum::reference {

/// Some weighted samples: of von Mises-Fisher lobes weight * (mean vector, 1), of Gaussians weight * (mean point,
/// mean square).
struct SampleSums {
  double weight = 0.0;
  glm::dvec3 sum{0.0};
  double square = 0.0;

  /// weight * square - |sum|^2, at least 0.
  double scatter() const;
};

SampleSums operator+(const SampleSums& a, const SampleSums& b);
SampleSums operator*(double weight, const SampleSums& sums);

/// Of a normal of length up to 1, and of a lobe (r, a); planar: of a sample of planar_sample(), and of a Gaussian (mean
/// x, mean y, sigma^2), a.
SampleSums sums_of_sample(const glm::dvec3& sample, bool planar);
SampleSums sums_of_lobe(const glm::dvec3& lobe, double amplitude, bool planar);

/// What lies around lobe j of a texel: parent[j] and, of each neighbour, neighbours[.][j], as the kernel weighs them.
std::vector<SampleSums> sums_around(const std::vector<SampleSums>& parent,
                                    const std::vector<std::vector<SampleSums>>& neighbours);

struct ChoiceOptions {
  double kappa_cap = 500.0;
  double alignment = 1.4;
};

/// The cost of giving sample i to lobe lobes[i].
double cost_of_choice(const std::vector<SampleSums>& samples, const std::vector<int>& lobes,
                      const std::vector<SampleSums>& around, const ChoiceOptions& options);

/// The way that costs least: the lobe of each sample.
std::vector<int> least_choice(const std::vector<SampleSums>& samples, const std::vector<SampleSums>& around,
                              const ChoiceOptions& options);

}  // namespace multum::reference
