// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/planar_em.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace multum::reference {
namespace {

// Returns the mean squared distance between a sample and a point, per coordinate.
double half_distance(const Sample& s, const glm::dvec2& point) {
  const glm::dvec2 d = glm::dvec2(s.normal) - point;
  return 0.5 * (glm::dot(d, d) + s.normal.z);
}

// Returns the mean and sigma^2 of samples with these shares.
glm::dvec3 mean_and_variance(const std::vector<Sample>& samples, const std::vector<double>& shares) {
  double total = 0.0, variance = 0.0;
  glm::dvec2 mean(0.0);
  for (std::size_t i = 0; i < samples.size(); ++i) {
    total += shares[i];
    mean += shares[i] * glm::dvec2(samples[i].normal);
  }
  mean /= total;
  for (std::size_t i = 0; i < samples.size(); ++i) variance += shares[i] * half_distance(samples[i], mean) / total;
  return {mean, variance};
}

double planar_kappa_cap(const std::vector<Sample>& samples, const EmOptions& options) {
  std::vector<double> weights;
  for (const Sample& s : samples) weights.push_back(s.weight);
  const double kappa = 1.0 / std::max(mean_and_variance(samples, weights).z, 1e-6);
  return std::min(options.kappa_cap + options.kappa_cap_slope * kappa, 1e6);
}

// Performs the E-step: returns the lobes' shares of one sample.
std::vector<double> shares_of(const Sample& s, const std::vector<Lobe>& lobes, double copies) {
  std::vector<double> shares;
  for (const Lobe& lobe : lobes)
    shares.push_back(std::log(std::max(lobe.amplitude, 1e-6)) +
                     copies * (std::log(lobe.kappa) - lobe.kappa * half_distance(s, glm::dvec2(lobe.mu))));
  const double largest = *std::max_element(shares.begin(), shares.end());
  double total = 0.0;
  for (double& share : shares) total += share = std::exp(share - largest);
  for (double& share : shares) share *= s.weight / total;
  return shares;
}

}  // namespace

glm::dvec3 planar_sample(const glm::dvec3& normal, bool shortened) {
  if (!shortened) return {normal.x, normal.y, 0.0};
  const double c = std::min(glm::length(normal), 1.0);
  const glm::dvec2 p = glm::dvec2(normal) / glm::length(normal);
  const double square = glm::dot(p, p), facets = (1.0 - c) / (2.0 - c);
  return {p, std::min(2.0 * facets * (1.0 - 0.5 * square), 1.0 - square)};
}

std::vector<Moments> fit_planar(const std::vector<Sample>& samples, std::vector<Lobe>& lobes,
                                const EmOptions& options) {
  const double cap = planar_kappa_cap(samples, options);
  double total_weight = 0.0;
  for (const Sample& s : samples) total_weight += s.weight;
  std::vector<Moments> moments(lobes.size());
  for (int iteration = 0; iteration < options.iterations; ++iteration) {
    std::vector<std::vector<double>> shares(lobes.size());
    for (const Sample& s : samples) {
      const std::vector<double> of_sample = shares_of(s, lobes, options.copies);
      for (std::size_t j = 0; j < lobes.size(); ++j) shares[j].push_back(of_sample[j]);
    }
    for (std::size_t j = 0; j < lobes.size(); ++j) {
      double amplitude = 0.0;
      for (const double share : shares[j]) amplitude += share / total_weight;
      const bool alive = amplitude > 1e-7;
      const glm::dvec3 r =
          alive ? mean_and_variance(samples, shares[j]) : glm::dvec3(lobes[j].mu.x, lobes[j].mu.y, 0.0);
      moments[j] = {r, r.z, amplitude};
    }
    if (iteration + 1 == options.iterations) break;
    for (std::size_t j = 0; j < lobes.size(); ++j) {
      const glm::dvec3 prior = options.prior.empty() ? glm::dvec3(0.0) : options.prior[j];
      const glm::dvec2 mean(moments[j].r), mu = (mean + glm::dvec2(prior)) / (1.0 + prior.z);
      const double variance = moments[j].spread + 0.5 * glm::dot(mu - mean, mu - mean);
      const double fitted = moments[j].amplitude > 1e-7 ? 1.0 / std::max(variance, 1e-7) : lobes[j].kappa;
      lobes[j] = {glm::dvec3(mu, 0.0), std::clamp(fitted, 0.05, cap), moments[j].amplitude};
    }
  }
  return moments;
}

double facet_variance(double s, double mean_square) { return (1.0 - 0.5 * std::min(mean_square, 1.0)) / (s + 3.0); }

double gmm_density(const glm::dvec4& lobe, double s, const glm::dvec3& h) {
  if (lobe.w <= 0.0) return 0.0;
  const glm::dvec2 mean = glm::dvec2(lobe) / lobe.w, d = glm::dvec2(h) - mean;
  const double square = glm::dot(mean, mean), spread = std::max(0.5 * (lobe.z / lobe.w - square), 0.0);
  const double variance = std::max(spread + facet_variance(s, square), 1e-7);
  return lobe.w / (2.0 * M_PI * variance) * std::exp(-0.5 * glm::dot(d, d) / variance) * std::max(h.z, 0.0);
}

double gmm_lambert(const glm::dvec4& lobe, const glm::dvec3& light) {
  if (lobe.w <= 0.0) return 0.0;
  const glm::dvec2 mean = glm::dvec2(lobe) / lobe.w;
  const double z = std::sqrt(std::max(1.0 - glm::dot(mean, mean), 0.0));
  return lobe.w * std::max(glm::dot(glm::dvec3(mean, z), light), 0.0);
}

}  // namespace multum::reference
