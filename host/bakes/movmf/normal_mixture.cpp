// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/normal_mixture.h"

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <numeric>

#include "host/foundation/base/mean_cosine.h"

namespace multum {

MixtureFit start_mixture(const Normals& normals, const std::vector<std::size_t>& chosen, bool is_shortened) {
  MixtureFit fit;
  for (std::size_t i : chosen) {
    MixtureLobe lobe{normals[i], 0.95, 30.0, 1.0 / static_cast<double>(chosen.size())};
    if (is_shortened) {  // the lobe has the width of the normal's own lobe, because on a flat surface lobes differ only
                         // in width
      const double length = glm::length(normals[i]);
      lobe = {normals[i] / length, 0.95 * length, kappa_of_mean_cosine(0.95 * length, 30.0), lobe.amplitude};
    }
    fit.lobes.push_back(lobe);
  }
  return fit;
}

void iterate_mixture(MixtureFit& fit, const Normals& normals, int iterations, double kappa_max, double copies) {
  const std::size_t count = fit.lobes.size();
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::array<double, 8> constant{}, weight{};
    std::array<glm::dvec3, 8> sum{};
    for (std::size_t j = 0; j < count; ++j) {
      const MixtureLobe& lobe = fit.lobes[j];
      const double peak = lobe.kappa / (1.0 - std::exp(-2.0 * lobe.kappa));
      constant[j] = std::log(std::max(lobe.amplitude, 1e-6) * lobe.kappa / (1.0 - std::exp(-2.0 * lobe.kappa))) +
                    (copies - 1.0) * std::log(peak);
    }
    double log_likelihood = 0.0;
    for (const glm::dvec3& n : normals) {
      std::array<double, 8> e{};
      double largest = -HUGE_VAL, total = 0.0;
      for (std::size_t j = 0; j < count; ++j) {
        e[j] = constant[j] + copies * fit.lobes[j].kappa * (glm::dot(fit.lobes[j].mu, n) - 1.0);
        largest = std::max(largest, e[j]);
      }
      for (std::size_t j = 0; j < count; ++j) total += e[j] = std::exp(e[j] - largest);
      log_likelihood += largest + std::log(total);
      for (std::size_t j = 0; j < count; ++j) {
        weight[j] += e[j] / total;
        sum[j] += e[j] / total * n;
      }
    }
    fit.log_likelihood = log_likelihood / static_cast<double>(normals.size());
    for (std::size_t j = 0; j < count; ++j) {
      MixtureLobe& lobe = fit.lobes[j];
      lobe.amplitude = weight[j] / static_cast<double>(normals.size());
      const double length = glm::length(sum[j]);
      if (weight[j] < 1e-9 || length < 1e-9) continue;
      lobe.mu = sum[j] / length;
      lobe.mean_length = std::min(length / weight[j], 1.0);
      lobe.kappa = kappa_of_mean_cosine(lobe.mean_length, kappa_max);
    }
  }
}

std::vector<std::size_t> farthest_first_normals(const Normals& normals, int count) {
  const glm::dvec3 mean = std::accumulate(normals.begin(), normals.end(), glm::dvec3(0.0));
  // closest[i] is the cosine between normal i and the nearest chosen normal. Before the first choice, the mean is used.
  std::vector<double> closest(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) closest[i] = glm::dot(normals[i], mean);
  std::vector<std::size_t> chosen;
  for (int j = 0; j < count; ++j) {
    chosen.push_back(static_cast<std::size_t>(std::min_element(closest.begin(), closest.end()) - closest.begin()));
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const double cosine = glm::dot(normals[i], normals[chosen.back()]);
      closest[i] = j == 0 ? cosine : std::max(closest[i], cosine);
    }
  }
  return chosen;
}

}  // namespace multum
