// SPDX-License-Identifier: Apache-2.0
#include "host/bake/movmf_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "host/bake/parallel_rows.h"

namespace multum {
namespace {

using Normals = std::vector<glm::dvec3>;

// Normals of a rectangle on a regular grid, at most about `sample_max`.
Normals sample_normals(const NormalMap& map, const TexelRectangle& where, double sample_max) {
  const double area = static_cast<double>(where.x1 - where.x0) * (where.y1 - where.y0);
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(area / sample_max))));
  Normals normals;
  for (int y = where.y0 + (stride - 1) / 2; y < where.y1; y += stride)
    for (int x = where.x0 + (stride - 1) / 2; x < where.x1; x += stride) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x);
      normals.emplace_back(static_cast<double>(map.x[i]), static_cast<double>(map.y[i]), static_cast<double>(map.z[i]));
    }
  if (normals.empty()) {  // a strip thinner than the stride
    const auto i =
        static_cast<std::size_t>(where.y0) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(where.x0);
    normals.emplace_back(static_cast<double>(map.x[i]), static_cast<double>(map.y[i]), static_cast<double>(map.z[i]));
  }
  return normals;
}

struct Lobe {
  glm::dvec3 mu;
  double mean_length;
  double kappa;
  double amplitude;
};

struct Fit {
  std::vector<Lobe> lobes;
  double log_likelihood = -HUGE_VAL;
};

// kappa of a mean length: Banerjee's start and two Newton steps.
double kappa_of(double r, double kappa_max) {
  r = std::min(r, 1.0 - 1e-9);
  if (r > 0.9) return std::min(1.0 / (1.0 - r), kappa_max);
  double kappa = std::max((3.0 * r - r * r * r) / (1.0 - r * r), 0.05);
  for (int step = 0; step < 2; ++step) {
    const double a = 1.0 / std::tanh(kappa) - 1.0 / kappa;
    kappa = std::max(kappa - (a - r) / (1.0 - a * a - 2.0 * a / kappa), 0.05);
  }
  return std::min(kappa, kappa_max);
}

Fit start_from(const Normals& normals, const std::vector<std::size_t>& chosen) {
  Fit fit;
  for (std::size_t i : chosen) fit.lobes.push_back({normals[i], 0.95, 30.0, 1.0 / static_cast<double>(chosen.size())});
  return fit;
}

// EM in double, Han et al. 2007, section 7, Algorithm 1, without alignment.
void iterate(Fit& fit, const Normals& normals, int iterations, double kappa_max) {
  const std::size_t count = fit.lobes.size();
  for (int iteration = 0; iteration < iterations; ++iteration) {
    std::array<double, 8> constant{}, weight{};
    std::array<glm::dvec3, 8> sum{};
    for (std::size_t j = 0; j < count; ++j) {
      const Lobe& lobe = fit.lobes[j];
      constant[j] = std::log(std::max(lobe.amplitude, 1e-6) * lobe.kappa / (1.0 - std::exp(-2.0 * lobe.kappa)));
    }
    double log_likelihood = 0.0;
    for (const glm::dvec3& n : normals) {
      std::array<double, 8> e{};
      double largest = -HUGE_VAL, total = 0.0;
      for (std::size_t j = 0; j < count; ++j) {
        e[j] = constant[j] + fit.lobes[j].kappa * (glm::dot(fit.lobes[j].mu, n) - 1.0);
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
      Lobe& lobe = fit.lobes[j];
      lobe.amplitude = weight[j] / static_cast<double>(normals.size());
      const double length = glm::length(sum[j]);
      if (weight[j] < 1e-9 || length < 1e-9) continue;
      lobe.mu = sum[j] / length;
      lobe.mean_length = std::min(length / weight[j], 1.0);
      lobe.kappa = kappa_of(lobe.mean_length, kappa_max);
    }
  }
}

std::vector<std::size_t> farthest_first(const Normals& normals, int count) {
  const glm::dvec3 mean = std::accumulate(normals.begin(), normals.end(), glm::dvec3(0.0));
  // closest[i] = cosine between normal i and the nearest choice so far; at first, the mean stands for the choices.
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

// Splittable generator (Steele, Lea, Flood 2014): trial t of a seed is the same whatever thread runs it.
std::uint64_t mix(std::uint64_t z) {
  z += 0x9e3779b97f4a7c15u;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

Fit best_of(std::vector<Fit>& fits) {
  return *std::max_element(fits.begin(), fits.end(),
                           [](const Fit& a, const Fit& b) { return a.log_likelihood < b.log_likelihood; });
}

}  // namespace

std::vector<MultumVmfLobe> farthest_first_lobes(const NormalMap& map, const TexelRectangle& where, int lobe_count) {
  const Normals normals = sample_normals(map, where, 16384.0);
  std::vector<MultumVmfLobe> lobes;
  for (std::size_t i : farthest_first(normals, lobe_count)) {
    const glm::vec3 r(normals[i] * 0.95);  // A(20)
    lobes.push_back({r.x, r.y, r.z, 1.0f / static_cast<float>(lobe_count)});
  }
  return lobes;
}

std::vector<MultumVmfLobe> likeliest_lobes(const NormalMap& map, const StartSearch& search) {
  // Many short trials on few normals, the best few longer on more: 0.2 s on one core, whatever the map's size. About
  // one random trial in 30 finds the basin of the best optimum of the four-quarter map; of 128, all but 1 % of seeds
  // do.
  constexpr int kTrials = 128, kKept = 8;
  constexpr int kShortIterations = 12, kLongIterations = 30;
  const TexelRectangle all = {0, 0, map.width, map.height};
  const Normals few = sample_normals(map, all, 1024.0);
  const Normals many = sample_normals(map, all, 4096.0);
  const auto cap = static_cast<double>(search.kappa_max);
  std::vector<Fit> fits(kTrials);
  parallel_rows(kTrials, search.threads, [&](int trial) {
    std::vector<std::size_t> chosen;
    if (trial == 0) chosen = farthest_first(few, search.lobe_count);
    for (int j = static_cast<int>(chosen.size()); j < search.lobe_count; ++j)
      chosen.push_back(mix(search.seed * 0x100000001b3u + static_cast<std::uint64_t>(trial * 8 + j)) % few.size());
    Fit fit = start_from(few, chosen);
    iterate(fit, few, kShortIterations, cap);
    fits[static_cast<std::size_t>(trial)] = std::move(fit);
  });
  std::stable_sort(fits.begin(), fits.end(),
                   [](const Fit& a, const Fit& b) { return a.log_likelihood > b.log_likelihood; });
  fits.resize(kKept);
  parallel_rows(kKept, search.threads,
                [&](int i) { iterate(fits[static_cast<std::size_t>(i)], many, kLongIterations, cap); });
  std::vector<MultumVmfLobe> lobes;
  for (const Lobe& lobe : best_of(fits).lobes) {
    const glm::vec3 r(lobe.mu * std::min(lobe.mean_length, 1.0));
    lobes.push_back({r.x, r.y, r.z, static_cast<float>(lobe.amplitude)});
  }
  return lobes;
}

}  // namespace multum
