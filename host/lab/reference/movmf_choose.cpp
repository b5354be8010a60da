// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/movmf_choose.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

#include "kernels/shared/movmf_choose.h"

namespace multum::reference {
namespace {

double width(const SampleSums& sums, double kappa_cap) {
  return std::sqrt(sums.scatter() + sums.weight * sums.weight * 0.5 / kappa_cap);
}

}  // namespace

double SampleSums::scatter() const { return std::max(weight * square - glm::dot(sum, sum), 0.0); }

SampleSums operator+(const SampleSums& a, const SampleSums& b) {
  return {a.weight + b.weight, a.sum + b.sum, a.square + b.square};
}

SampleSums operator*(double weight, const SampleSums& sums) {
  return {weight * sums.weight, weight * sums.sum, weight * sums.square};
}

SampleSums sums_of_sample(const glm::dvec3& sample, bool planar) {
  if (!planar) return {1.0, sample, 1.0};  // facets are unit vectors
  const glm::dvec3 point(sample.x, sample.y, 0.0);
  return {1.0, point, glm::dot(point, point) + sample.z};
}

SampleSums sums_of_lobe(const glm::dvec3& lobe, double amplitude, bool planar) {
  if (!planar) return amplitude * SampleSums{1.0, lobe, 1.0};
  const glm::dvec3 point(lobe.x, lobe.y, 0.0);
  return amplitude * SampleSums{1.0, point, glm::dot(point, point) + 2.0 * lobe.z};
}

std::vector<SampleSums> sums_around(const std::vector<SampleSums>& parent,
                                    const std::vector<std::vector<SampleSums>>& neighbours) {
  constexpr double kParent = static_cast<double>(MULTUM_CHOICE_PARENT);
  const double texels = static_cast<double>(MULTUM_CHOICE_AROUND) / (kParent + static_cast<double>(neighbours.size()));
  std::vector<SampleSums> around;
  for (std::size_t j = 0; j < parent.size(); ++j) {
    SampleSums sum = kParent * parent[j];
    for (const std::vector<SampleSums>& lobes : neighbours) sum = sum + lobes[j];
    around.push_back(MULTUM_CHOICE_NORMALS * texels * sum);
  }
  return around;
}

double cost_of_choice(const std::vector<SampleSums>& samples, const std::vector<int>& lobes,
                      const std::vector<SampleSums>& around, const ChoiceOptions& options) {
  double cost = 0.0;
  for (std::size_t j = 0; j < around.size(); ++j) {
    SampleSums own;
    for (std::size_t i = 0; i < samples.size(); ++i)
      if (lobes[i] == static_cast<int>(j)) own = own + samples[i];
    cost += width(own, options.kappa_cap) + options.alignment * width(own + around[j], options.kappa_cap);
  }
  return cost;
}

std::vector<int> least_choice(const std::vector<SampleSums>& samples, const std::vector<SampleSums>& around,
                              const ChoiceOptions& options) {
  const int lobe_count = static_cast<int>(around.size());
  std::vector<int> lobes(samples.size(), 0), best;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samples.size();) {
    if (const double cost = cost_of_choice(samples, lobes, around, options); cost < least) {
      least = cost;
      best = lobes;
    }
    // Counts up by one in base lobe_count, which gives the next assignment.
    for (i = 0; i < samples.size() && ++lobes[i] == lobe_count; ++i) lobes[i] = 0;
  }
  return best;
}

}  // namespace multum::reference
