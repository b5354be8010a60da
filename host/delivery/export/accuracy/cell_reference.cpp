// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/accuracy/cell_reference.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <glm/geometric.hpp>

#include "host/delivery/export/one_lobe_fit.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

constexpr double kViewAngles[] = {0.0, 17.5, 35.0, 52.5, 70.0};  // angle to the map's z axis, degrees
constexpr double kWideLightAngle = 10.0;                         // half angle of a wide light, degrees
// The share of point lights that are drawn from the wide lobe.
constexpr double kWideShare = 0.25;

struct Frame3 {
  explicit Frame3(const glm::dvec3& normal) : x(tangent_about(normal)), y(glm::cross(normal, x)), z(normal) {}
  glm::dvec3 at(double a, double b, double c) const { return a * x + b * y + c * z; }
  glm::dvec3 x, y, z;
};

// Draws a half vector with the density D (n . h) of GGX.
glm::dvec3 random_half_vector(const glm::dvec3& normal, double alpha, SplitMix64& random) {
  const double u = 1.0 - random.uniform(), azimuth = 2.0 * std::numbers::pi * random.uniform();
  const double slope = alpha * std::sqrt(u / (1.0 - u));
  return glm::normalize(Frame3(normal).at(slope * std::cos(azimuth), slope * std::sin(azimuth), 1.0));
}

double density_of(const glm::dvec3& normal, double alpha, const glm::dvec3& half) {
  const double nh = glm::dot(normal, half), a2 = alpha * alpha, d = nh * nh * (a2 - 1.0) + 1.0;
  return nh > 0.0 ? a2 / (std::numbers::pi * d * d) * nh : 0.0;
}

// Returns a lobe that is 1.5 times as wide as the facets and normals together.
GgxLobe wide_lobe(const CoveredFacets& facets) {
  const double spread = 2.0 * (1.0 - glm::length(facets.mean_normal));
  return GgxLobe::isotropic(glm::normalize(facets.mean_normal),
                            std::clamp(1.5 * std::sqrt(facets.mean_alpha_squared + 2.0 * spread), 0.1, 1.0));
}

std::vector<LightSet> empty_views(SplitMix64& random) {
  std::vector<LightSet> views;
  double azimuth = random.uniform();
  for (const double degrees : kViewAngles) {
    const double polar = degrees * std::numbers::pi / 180.0, turn = 2.0 * std::numbers::pi * azimuth;
    LightSet set;
    set.view = {std::sin(polar) * std::cos(turn), std::sin(polar) * std::sin(turn), std::cos(polar)};
    views.push_back(std::move(set));
    azimuth += std::numbers::phi;
  }
  return views;
}

// Only lights above the surface are included. Lights below it are hidden by the surface itself, even if the mapped
// normal faces them.
bool is_lit(const glm::dvec3& view, const glm::dvec3& half, const glm::dvec3& light) {
  return light.z > 0.0 && glm::dot(view, half) > 1e-6;
}

// Adds the mean highlights and the mean facet densities D (n . h).
void add_reference(const CoveredFacets& facets, const LightSet& lights, std::vector<double>& values,
                   std::vector<double>& densities) {
  values.assign(lights.size(), 0.0);
  densities.assign(lights.size(), 0.0);
  for (std::size_t i = 0; i < facets.normals.size(); ++i)
    add_highlights(lights, facets.normals[i], facets.alpha_squared[i], facets.weights[i], values.data(),
                   densities.data());
}

// Adds the integral and its noise. The terms are independent.
void add_totals(ReferenceLights& lights, std::size_t points) {
  double sum = 0.0, squares = 0.0;
  for (std::size_t v = 0; v < lights.views.size(); ++v)
    for (std::size_t i = 0; i < lights.values[v].size(); i += points) {
      double term = 0.0;
      for (std::size_t k = i; k < i + points; ++k) term += lights.values[v][k] * lights.views[v].share[k];
      sum += term;
      squares += term * term;
    }
  lights.total = sum;
  lights.noise = sum > 0.0 ? std::sqrt(squares) / sum : 0.0;
}

}  // namespace

double covered_length(int index, int texel, int from, int to) {
  const double step = static_cast<double>(from) / to;
  return std::min(index + 1.0, (texel + 1) * step) - std::max<double>(index, texel * step);
}

CoveredFacets covered_facets(const PlaneStore& normals, const PlaneStore* material, double alpha_squared, int width,
                             int height, int x, int y) {
  const auto first = [](int texel, int from, int to) { return static_cast<int>(std::int64_t{texel} * from / to); };
  const auto end = [](int texel, int from, int to) {
    return static_cast<int>((std::int64_t{texel + 1} * from + to - 1) / to);
  };
  const int w = normals.width(), h = normals.height();
  CoveredFacets facets;
  double weight_sum = 0.0;
  std::vector<float> nx(size_of(w)), ny(nx), nz(nx), base(nx);
  for (int row = first(y, h, height); row < end(y, h, height); ++row) {
    normals.read_rows(row, 1, {nx.data(), ny.data(), nz.data()});
    if (material != nullptr) material->read_rows(0, row, 1, base.data());
    for (int column = first(x, w, width); column < end(x, w, width); ++column) {
      const double weight = covered_length(row, y, h, height) * covered_length(column, x, w, width);
      const std::size_t i = size_of(column);
      const glm::dvec3 n(static_cast<double>(nx[i]), static_cast<double>(ny[i]), static_cast<double>(nz[i]));
      const double a2 =
          std::max(kAlphaMin * kAlphaMin, material != nullptr ? static_cast<double>(base[i]) : alpha_squared);
      if (!(glm::length(n) > 1e-6) || weight <= 0.0) continue;
      facets.normals.push_back(glm::normalize(n));
      facets.alpha_squared.push_back(a2);
      facets.weights.push_back(weight);
      facets.mean_normal += weight * facets.normals.back();
      facets.mean_roughness += weight * std::pow(a2, 0.25);
      facets.mean_alpha_squared += weight * a2;
      weight_sum += weight;
    }
  }
  for (double& weight : facets.weights) weight /= weight_sum;
  facets.mean_normal /= weight_sum;
  facets.mean_roughness /= weight_sum;
  facets.mean_alpha_squared /= weight_sum;
  return facets;
}

ReferenceLights point_lights(const CoveredFacets& facets, int lights_per_view, std::uint64_t seed) {
  SplitMix64 random(split_mix(seed));
  ReferenceLights lights;
  lights.views = empty_views(random);
  const GgxLobe wide = wide_lobe(facets);
  const int wide_count = static_cast<int>(kWideShare * lights_per_view), narrow_count = lights_per_view - wide_count;
  for (LightSet& set : lights.views) {
    double covered = 0.0;  // sum of the weights before texel `i`
    std::size_t i = 0;
    for (int k = 0; k < lights_per_view; ++k) {
      glm::dvec3 half;
      if (k < narrow_count) {
        // Takes the facets in turn. The number of samples of each texel is proportional to its weight.
        const double place = (k + random.uniform()) / narrow_count;
        while (i + 1 < facets.weights.size() && covered + facets.weights[i] < place) covered += facets.weights[i++];
        half = random_half_vector(facets.normals[i], std::sqrt(facets.alpha_squared[i]), random);
      } else {
        half = random_half_vector(wide.normal, wide.alpha_wide, random);
      }
      const glm::dvec3 light = 2.0 * glm::dot(set.view, half) * half - set.view;
      if (is_lit(set.view, half, light)) set.add(light);
    }
    std::vector<double> values, densities;
    add_reference(facets, set, values, densities);
    for (std::size_t l = 0; l < set.size(); ++l) {
      const glm::dvec3 half(set.hx[l], set.hy[l], set.hz[l]);
      const double density =
          (narrow_count * densities[l] + wide_count * density_of(wide.normal, wide.alpha_wide, half)) / lights_per_view;
      set.share[l] = 4.0 * glm::dot(set.view, half) / (density * lights_per_view);
    }
    lights.values.push_back(std::move(values));
  }
  add_totals(lights, 1);
  return lights;
}

ReferenceLights wide_lights(const CoveredFacets& facets, int lights_per_view, std::uint64_t seed) {
  SplitMix64 random(split_mix(seed));
  ReferenceLights lights;
  lights.views = empty_views(random);
  GgxLobe wide = wide_lobe(facets);
  wide.alpha_wide = wide.alpha_narrow = std::max(wide.alpha_wide, 0.25);
  const double least_cosine = std::cos(kWideLightAngle * std::numbers::pi / 180.0);
  for (LightSet& set : lights.views) {
    std::vector<double> shares;
    for (int k = 0; k < lights_per_view; ++k) {
      const glm::dvec3 half = random_half_vector(wide.normal, wide.alpha_wide, random);
      const glm::dvec3 light = 2.0 * glm::dot(set.view, half) * half - set.view;
      if (!is_lit(set.view, half, light)) continue;
      const double density = density_of(wide.normal, wide.alpha_wide, half);
      const double share = 4.0 * glm::dot(set.view, half) / (density * lights_per_view) / double{kWideLightPoints};
      // The points form a spiral that covers the disc. Points behind the surface emit no light.
      const Frame3 about(light);
      const double turn = random.uniform();
      for (std::size_t p = 0; p < kWideLightPoints; ++p) {
        const double cosine = 1.0 - (1.0 - least_cosine) * (static_cast<double>(p) + 0.5) / double{kWideLightPoints};
        const double sine = std::sqrt(1.0 - cosine * cosine);
        const double azimuth = 2.0 * std::numbers::pi * (turn + static_cast<double>(p) * std::numbers::phi);
        const glm::dvec3 point = about.at(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine);
        set.add(point);
        shares.push_back(point.z > 0.0 ? share : 0.0);
      }
    }
    set.share = std::move(shares);
    std::vector<double> values, densities;
    add_reference(facets, set, values, densities);
    lights.values.push_back(std::move(values));
  }
  add_totals(lights, kWideLightPoints);
  return lights;
}

LobeError error_of_highlights(const ReferenceLights& lights, const HighlightsOf& highlights_of, std::size_t points) {
  double difference = 0.0, energy = 0.0;
  std::vector<double> values;
  for (std::size_t v = 0; v < lights.views.size(); ++v) {
    const LightSet& set = lights.views[v];
    highlights_of(set, values);
    for (std::size_t i = 0; i < values.size(); i += points) {
      double of_light = 0.0;
      for (std::size_t k = i; k < i + points; ++k) {
        of_light += (values[k] - lights.values[v][k]) * set.share[k];
        energy += values[k] * set.share[k];
      }
      difference += std::abs(of_light);
    }
  }
  if (lights.total <= 0.0) return {};
  return {difference / lights.total, energy / lights.total};
}

LobeError error_of_lobe(const ReferenceLights& lights, const GgxLobe& lobe, std::size_t points) {
  return error_of_highlights(
      lights, [&](const LightSet& set, std::vector<double>& values) { highlights(set, lobe, values); }, points);
}

}  // namespace multum
