// SPDX-License-Identifier: Apache-2.0
// Assigns each of a texel's four normals to a lobe, in double precision, by trying every assignment. This code is the
// reference for kernels/movmf_choose.cl, which defines the cost. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum::reference {

/// Contains sums over weighted samples. For von Mises-Fisher lobes, each sample adds weight * (mean vector, 1). For
/// Gaussians, each sample adds weight * (mean point, mean square).
struct SampleSums {
  double weight = 0.0;
  glm::dvec3 sum{0.0};
  double square = 0.0;

  /// Returns weight * square - |sum|^2, or 0 if this number is negative.
  double scatter() const;
};

SampleSums operator+(const SampleSums& a, const SampleSums& b);
SampleSums operator*(double weight, const SampleSums& sums);

/// Returns the sums of one sample. The sample is a normal of length up to 1, or a lobe (r, a). If `planar` is true, it
/// is a result of planar_sample(), or a Gaussian (mean x, mean y, sigma^2) with amplitude a.
SampleSums sums_of_sample(const glm::dvec3& sample, bool planar);
SampleSums sums_of_lobe(const glm::dvec3& lobe, double amplitude, bool planar);

/// Returns the weighted sums of the lobes around lobe j of a texel. These lobes are parent[j] and, for each neighbour,
/// neighbours[.][j]. The weights are the same as in the kernel.
std::vector<SampleSums> sums_around(const std::vector<SampleSums>& parent,
                                    const std::vector<std::vector<SampleSums>>& neighbours);

struct ChoiceOptions {
  double kappa_cap = 500.0;
  double alignment = 1.4;
};

/// Returns the cost of assigning each sample i to lobe lobes[i].
double cost_of_choice(const std::vector<SampleSums>& samples, const std::vector<int>& lobes,
                      const std::vector<SampleSums>& around, const ChoiceOptions& options);

/// Returns the assignment with the lowest cost, which consists of one lobe index per sample.
std::vector<int> least_choice(const std::vector<SampleSums>& samples, const std::vector<SampleSums>& around,
                              const ChoiceOptions& options);

}  // namespace multum::reference
