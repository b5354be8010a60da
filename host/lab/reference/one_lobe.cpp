// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/one_lobe.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "host/lab/reference/coverage.h"

namespace multum::reference {
namespace {

constexpr double kSpreadFactor = 1.75, kFacetCosineMin = 0.05, kScaleMin = 1e-8, kCorrelationMax = 0.996;

glm::dvec3 usable(const glm::dvec3& n) {
  const double square = glm::dot(n, n);
  return square > 1e-12 && square < 1e12 ? n / std::sqrt(square) : glm::dvec3(0.0, 0.0, 1.0);
}

glm::dvec3 normal_at(const NormalMap& map, std::size_t i) {
  return usable({static_cast<double>(map.x[i]), static_cast<double>(map.y[i]), static_cast<double>(map.z[i])});
}

// Returns two axes of the normal's tangent plane. The first is the x axis, rotated into this plane, and the second is
// perpendicular to the first and to the normal.
struct Frame {
  explicit Frame(const glm::dvec3& normal) : z(normal) {
    x = glm::normalize(glm::dvec3(1.0, 0.0, 0.0) - normal.x * normal);
    y = glm::cross(normal, x);
  }
  glm::dvec3 x, y, z;
};

double base_at(const OneLobeTexel& texel, std::size_t i) {
  return texel.base_squared.size() == 1 ? texel.base_squared[0] : texel.base_squared[i];
}

struct TexelMeans {
  glm::dvec3 normal{0.0};
  glm::dmat3 products{0.0};
  double base = 0.0;
};

TexelMeans means_of(const OneLobeTexel& texel) {
  TexelMeans means;
  double weights = 0.0;
  for_each_covered(texel.map->width, texel.map->height, texel.width, texel.height, texel.x, texel.y,
                   [&](std::size_t i, double weight) {
                     const glm::dvec3 n = normal_at(*texel.map, i);
                     means.normal += weight * n;
                     means.products += weight * glm::outerProduct(n, n);
                     means.base += weight * base_at(texel, i);
                     weights += weight;
                   });
  means.normal /= weights;
  means.products /= weights;
  means.base /= weights;
  return means;
}

glm::dmat2 bounded(glm::dmat2 s, bool is_anisotropic) {
  s[0][0] = std::max(s[0][0], kScaleMin);
  s[1][1] = std::max(s[1][1], kScaleMin);
  if (!is_anisotropic) return glm::dmat2(0.5 * (s[0][0] + s[1][1]));
  const double most = kCorrelationMax * std::sqrt(s[0][0] * s[1][1]);
  s[0][1] = s[1][0] = std::clamp(s[0][1], -most, most);
  return s;
}

// Runs one step of EM, as described at the top of kernels/one_lobe.cl.
void em_step(const std::vector<glm::dvec2>& slopes, glm::dvec2& mean, glm::dmat2& scale, bool is_anisotropic) {
  const glm::dmat2 inverse = glm::inverse(scale);
  std::vector<double> weights;
  double weight_sum = 0.0;
  glm::dvec2 moved(0.0);
  for (const glm::dvec2& x : slopes) {
    weights.push_back(4.0 / (2.0 + glm::dot(x - mean, inverse * (x - mean))));
    weight_sum += weights.back();
    moved += weights.back() * x;
  }
  mean = moved / weight_sum;
  glm::dmat2 sum(0.0);
  for (std::size_t i = 0; i < slopes.size(); ++i)
    sum += weights[i] * glm::outerProduct(slopes[i] - mean, slopes[i] - mean);
  scale = bounded(sum / weight_sum, is_anisotropic);
}

}  // namespace

std::vector<glm::dvec2> sampled_slopes(const OneLobeTexel& texel, const std::vector<glm::vec2>& facets, int grid) {
  const NormalMap& map = *texel.map;
  const Frame frame(usable(means_of(texel).normal));
  const auto place = [grid](int coarse_texel, int sample, int coarse, int fine) {
    return static_cast<std::size_t>((coarse_texel + (sample + 0.5) / grid) * fine / coarse);
  };
  std::vector<glm::dvec2> slopes;
  for (int j = 0; j < grid; ++j)
    for (int i = 0; i < grid; ++i) {
      const std::size_t at = place(texel.y, j, texel.height, map.height) * static_cast<std::size_t>(map.width) +
                             place(texel.x, i, texel.width, map.width);
      const Frame about(normal_at(map, at));
      const glm::dvec2 facet =
          std::sqrt(base_at(texel, at)) * glm::dvec2(facets[static_cast<std::size_t>(j * grid + i)]);
      const glm::dvec3 half = about.z + facet.x * about.x + facet.y * about.y;
      const double cosine = std::max(glm::dot(half, frame.z), kFacetCosineMin * glm::length(half));
      slopes.emplace_back(glm::dot(half, frame.x) / cosine, glm::dot(half, frame.y) / cosine);
    }
  return slopes;
}

OneLobe fit_one_lobe(const OneLobeTexel& texel, const std::vector<glm::vec2>& facets, int grid) {
  const TexelMeans means = means_of(texel);
  const Frame frame(usable(means.normal));
  const auto spread = [&](const glm::dvec3& a, const glm::dvec3& b) { return glm::dot(a, means.products * b); };
  glm::dmat2 scale = glm::dmat2(0.5 * means.base) + 0.5 * kSpreadFactor *
                                                        glm::dmat2(spread(frame.x, frame.x), spread(frame.x, frame.y),
                                                                   spread(frame.x, frame.y), spread(frame.y, frame.y));
  scale = bounded(scale, texel.is_anisotropic);
  glm::dvec2 mean(0.0);
  if (texel.iteration_count > 0) {
    const std::vector<glm::dvec2> slopes = sampled_slopes(texel, facets, grid);
    for (int i = 0; i < texel.iteration_count; ++i) em_step(slopes, mean, scale, texel.is_anisotropic);
  }
  OneLobe lobe;
  lobe.normal = glm::normalize(frame.z + mean.x * frame.x + mean.y * frame.y);
  const double middle = 0.5 * (scale[0][0] + scale[1][1]);
  const double radius = std::hypot(0.5 * (scale[0][0] - scale[1][1]), scale[0][1]);
  const auto alpha = [&](double eigenvalue) { return std::clamp(std::sqrt(2.0 * eigenvalue), texel.alpha_min, 1.0); };
  lobe.alpha_wide = alpha(middle + radius);
  lobe.alpha_narrow = alpha(std::max(0.0, middle - radius));
  const double angle = 0.5 * std::atan2(2.0 * scale[0][1], scale[0][0] - scale[1][1]);
  const glm::dvec3 axis = std::cos(angle) * frame.x + std::sin(angle) * frame.y;
  lobe.axis = glm::normalize(axis - glm::dot(axis, lobe.normal) * lobe.normal);
  return lobe;
}

double t_deviance(const std::vector<glm::dvec2>& slopes, const glm::dvec2& mean, const glm::dmat2& scale) {
  const glm::dmat2 inverse = glm::inverse(scale);
  double sum = 0.0;
  for (const glm::dvec2& x : slopes) sum += 4.0 * std::log1p(0.5 * glm::dot(x - mean, inverse * (x - mean)));
  return std::log(glm::determinant(scale)) + sum / static_cast<double>(slopes.size());
}

}  // namespace multum::reference
