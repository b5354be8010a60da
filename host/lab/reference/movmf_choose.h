// SPDX-License-Identifier: Apache-2.0
// Assigns each of a texel's four normals to a lobe, in double and by trying every assignment. This is the reference of
// kernels/movmf_choose.cl, which defines the cost. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum::reference {

/// Sums over weighted samples. Each sample adds weight * (mean vector, 1) for von Mises-Fisher lobes, or weight * (mean
/// point, mean square) for Gaussians.
struct SampleSums {
  double weight = 0.0;
  glm::dvec3 sum{0.0};
  double square = 0.0;

  /// Returns weight * square - |sum|^2, but at least 0.
  double scatter() const;
};

SampleSums operator+(const SampleSums& a, const SampleSums& b);
SampleSums operator*(double weight, const SampleSums& sums);

/// Returns the sums of one sample, which is a normal of length up to 1, or a lobe (r, a). If `planar` is true, the
/// sample is from planar_sample(), or is a Gaussian (mean x, mean y, sigma^2), a.
SampleSums sums_of_sample(const glm::dvec3& sample, bool planar);
SampleSums sums_of_lobe(const glm::dvec3& lobe, double amplitude, bool planar);

/// Returns the weighted sums of the lobes around lobe j of a texel. These lobes are parent[j], and neighbours[.][j] of
/// each neighbour. The weights are the weights of the kernel.
std::vector<SampleSums> sums_around(const std::vector<SampleSums>& parent,
                                    const std::vector<std::vector<SampleSums>>& neighbours);

struct ChoiceOptions {
  double kappa_cap = 500.0;
  double alignment = 1.4;
};

/// Returns the cost of assigning each sample i to lobe lobes[i].
double cost_of_choice(const std::vector<SampleSums>& samples, const std::vector<int>& lobes,
                      const std::vector<SampleSums>& around, const ChoiceOptions& options);

/// Returns the assignment with the lowest cost, as the lobe of each sample.
std::vector<int> least_choice(const std::vector<SampleSums>& samples, const std::vector<SampleSums>& around,
                              const ChoiceOptions& options);

}  // namespace multum::reference
