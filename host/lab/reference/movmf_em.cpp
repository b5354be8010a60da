// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/movmf_em.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace multum::reference {

double mean_length(double kappa) {
  if (kappa < 1e-3) return kappa / 3.0 - kappa * kappa * kappa / 45.0;
  return 1.0 / std::tanh(kappa) - 1.0 / kappa;
}

double kappa_of_mean_length(double r) {
  if (r <= 0.0) return 0.0;
  if (r >= 1.0) return HUGE_VAL;
  double low = 1e-12, high = 1e18;
  for (int step = 0; step < 200; ++step) {
    const double middle = std::sqrt(low * high);
    (mean_length(middle) < r ? low : high) = middle;
  }
  return std::sqrt(low * high);
}

double log_vmf(double t, double kappa) {
  if (kappa < 1e-9) return -std::log(4.0 * M_PI);
  return std::log(kappa / (2.0 * M_PI * -std::expm1(-2.0 * kappa))) + kappa * (t - 1.0);
}

namespace {

double texel_kappa_cap(const std::vector<Sample>& samples, const EmOptions& options) {
  glm::dvec3 sum(0.0);
  double weight = 0.0;
  for (const Sample& s : samples) {
    sum += s.weight * s.normal;
    weight += s.weight;
  }
  return std::min(
      options.kappa_cap + options.kappa_cap_slope * std::min(kappa_of_mean_length(glm::length(sum) / weight), 1e6),
      1e6);
}

}  // namespace

std::vector<Moments> fit(const std::vector<Sample>& samples, std::vector<Lobe>& lobes, const EmOptions& options) {
  const double cap = texel_kappa_cap(samples, options);
  double total_weight = 0.0;
  for (const Sample& s : samples) total_weight += s.weight;
  std::vector<Moments> moments(lobes.size());
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    // This is the E-step, equation 15.
    std::vector<double> share(lobes.size(), 0.0), gap(lobes.size(), 0.0);
    std::vector<glm::dvec3> sum(lobes.size(), glm::dvec3(0.0));
    for (const Sample& s : samples) {
      std::vector<double> density(lobes.size());
      for (std::size_t j = 0; j < lobes.size(); ++j)
        density[j] = std::log(std::max(lobes[j].amplitude, 1e-6)) +
                     options.copies * log_vmf(glm::dot(lobes[j].mu, s.normal), lobes[j].kappa);
      const double largest = *std::max_element(density.begin(), density.end());
      double total = 0.0;
      for (double& d : density) total += d = std::exp(d - largest);
      for (std::size_t j = 0; j < lobes.size(); ++j) {
        const double z = s.weight * density[j] / total;
        share[j] += z;
        sum[j] += z * s.normal;
      }
    }
    // These moments are stored.
    for (std::size_t j = 0; j < lobes.size(); ++j) {
      const double a = share[j] / total_weight;
      const glm::dvec3 r = share[j] > 0.0 ? sum[j] / share[j] : glm::dvec3(0.0);
      const double length = glm::length(r);
      const bool alignment_vectors = length > 1e-6 && a > 1e-7;
      moments[j] = {alignment_vectors ? r : lobes[j].mu * length, std::clamp(1.0 - length, 0.0, 1.0), a};
    }
    if (iteration + 1 == options.iterations) break;
    // This is the M-step, equation 16, with the prior.
    for (std::size_t j = 0; j < lobes.size(); ++j) {
      const glm::dvec3 v = moments[j].r + (options.prior.empty() ? glm::dvec3(0.0) : options.prior[j]);
      if (glm::length(v) > 1e-6) lobes[j].mu = glm::normalize(v);
      else if (glm::length(moments[j].r) > 1e-6) lobes[j].mu = glm::normalize(moments[j].r);
      if (moments[j].amplitude > 1e-7)
        lobes[j].kappa = std::clamp(kappa_of_mean_length(1.0 - moments[j].spread), 0.05, cap);
      else lobes[j].kappa = std::clamp(lobes[j].kappa, 0.05, cap);
      lobes[j].amplitude = moments[j].amplitude;
    }
  }
  return moments;
}

}  // namespace multum::reference
