// SPDX-License-Identifier: Apache-2.0
#include "host/formats/light/reflection_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/fresnel.h"
#include "host/formats/brdf/measured_brdf.h"
#include "host/formats/brdf/vmf_terms.h"

namespace multum {
namespace {

constexpr int kSampleCount = 512;

// Returns a point of the sequence of the generalized golden ratio (Roberts' R4).
std::array<double, 4> sequence(int i) {
  constexpr double kRatios[4] = {0.8566748838545029, 0.733891856627126, 0.6287067210378087, 0.5385972572236101};
  std::array<double, 4> u{};
  for (std::size_t k = 0; k < 4; ++k) {
    const double x = 0.5 + kRatios[k] * (i + 1);
    u[k] = x - std::floor(x);
  }
  return u;
}

// Draws a direction around `axis` from a vMF with this kappa.
glm::dvec3 sample_vmf(const glm::dvec3& axis, double kappa, double u, double w) {
  // Inverts the distribution of e = 1 - cosine, with exp(-kappa e) from 1 to exp(-2 kappa).
  const double e = kappa < 1e-4 ? 2.0 * u : -std::log1p(-u * -std::expm1(-2.0 * kappa)) / kappa;
  const double sine = std::sqrt(std::max(e * (2.0 - e), 0.0)), phi = 2.0 * std::numbers::pi * w;
  const glm::dvec3 side = glm::normalize(std::abs(axis.z) < 0.9 ? glm::cross(axis, glm::dvec3(0.0, 0.0, 1.0))
                                                                : glm::cross(axis, glm::dvec3(1.0, 0.0, 0.0)));
  return (1.0 - e) * axis + sine * (std::cos(phi) * side + std::sin(phi) * glm::cross(axis, side));
}

double visibility(const Brdf& brdf, double n_l, double n_v, double n_h, double v_h) {
  const auto of_family = family_of(brdf).visibility;
  return of_family == nullptr ? 1.0 : of_family(width_of(brdf), n_l, n_v, n_h, v_h);
}

ReflectionEntry integrate(const Brdf& brdf, const VmfTerm& term, double lobe_kappa, double cosine) {
  const glm::dvec3 mu(0.0, 0.0, 1.0), v(std::sqrt(std::max(1.0 - cosine * cosine, 0.0)), 0.0, cosine);
  ReflectionEntry entry{glm::dvec3(0.0), 0.0, 0.0};
  double diffuse = 0.0;
  for (int i = 0; i < kSampleCount; ++i) {
    const std::array<double, 4> u = sequence(i);
    const glm::dvec3 n = sample_vmf(mu, lobe_kappa, u[0], u[1]);
    // Cosine-weighted light around n, for the diffuse part.
    const glm::dvec3 around = n + sample_vmf(n, 0.0, u[2], u[3]);
    if (glm::length(around) > 1e-6) {
      entry.fresnel += schlick_part(glm::dot(v, glm::normalize(v + glm::normalize(around))));
      diffuse += 1.0;
    }
    const glm::dvec3 h = sample_vmf(n, term.kappa, u[2], u[3]);
    const double v_h = glm::dot(v, h);
    if (v_h <= 0.0) continue;
    const glm::dvec3 l = 2.0 * v_h * h - v;
    const double n_l = std::max(glm::dot(n, l), 0.0);
    entry.plain += 4.0 * v_h * v_h;
    const double weight =
        4.0 * v_h * n_l * visibility(brdf, n_l, std::max(glm::dot(n, v), 0.0), std::max(glm::dot(n, h), 0.0), v_h);
    entry.weight += weight * fresnel(brdf, v_h);
  }
  entry.weight *= term.weight / static_cast<double>(kSampleCount);
  entry.plain *= (term.weight.x + term.weight.y + term.weight.z) / 3.0 / kSampleCount;
  entry.fresnel /= std::max(diffuse, 1.0);
  return entry;
}

}  // namespace

std::vector<std::vector<ReflectionEntry>> reflection_tables(const Brdf& brdf) {
  std::vector<std::vector<ReflectionEntry>> tables;
  for (const VmfTerm& term : vmf_terms(brdf)) {
    std::vector<ReflectionEntry> table;
    for (int row = 0; row < kReflectionSpreadCount; ++row) {
      const double x = static_cast<double>(row) / (kReflectionSpreadCount - 1);
      const double kappa = vmf_kappa(std::clamp(x * x * x, 1e-8, 1.0 - 1e-6));
      for (int column = 0; column < kReflectionCosineCount; ++column)
        table.push_back(integrate(brdf, term, kappa, 2.0 * column / (kReflectionCosineCount - 1) - 1.0));
    }
    tables.push_back(std::move(table));
  }
  return tables;
}

}  // namespace multum
