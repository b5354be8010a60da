// SPDX-License-Identifier: Apache-2.0
#include "host/bake/movmf_start.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

namespace multum {
namespace {

constexpr double kSamplesMax = 16384.0;

std::vector<glm::dvec3> sample_normals(const NormalMap& map, const TexelRectangle& where) {
  const double area = static_cast<double>(where.x1 - where.x0) * (where.y1 - where.y0);
  const int stride = std::max(1, static_cast<int>(std::ceil(std::sqrt(area / kSamplesMax))));
  std::vector<glm::dvec3> normals;
  for (int y = where.y0; y < where.y1; y += stride)
    for (int x = where.x0; x < where.x1; x += stride) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x);
      normals.emplace_back(static_cast<double>(map.x[i]), static_cast<double>(map.y[i]), static_cast<double>(map.z[i]));
    }
  return normals;
}

}  // namespace

std::vector<MultumVmfLobe> farthest_first_lobes(const NormalMap& map, const TexelRectangle& where, int lobe_count) {
  const std::vector<glm::dvec3> normals = sample_normals(map, where);
  glm::dvec3 mean(0.0);
  for (const glm::dvec3& n : normals) mean += n;
  // closest[i] = cosine between normal i and the nearest choice so far; at first, the mean stands for the choices.
  std::vector<double> closest(normals.size());
  for (std::size_t i = 0; i < normals.size(); ++i) closest[i] = glm::dot(normals[i], mean);
  std::vector<MultumVmfLobe> lobes;
  for (int j = 0; j < lobe_count; ++j) {
    const auto farthest = static_cast<std::size_t>(std::min_element(closest.begin(), closest.end()) - closest.begin());
    const glm::dvec3 n = normals[farthest];
    constexpr double kMeanLength = 0.95;  // A(20)
    lobes.push_back({static_cast<float>(n.x * kMeanLength), static_cast<float>(n.y * kMeanLength),
                     static_cast<float>(n.z * kMeanLength), 1.0f / static_cast<float>(lobe_count)});
    for (std::size_t i = 0; i < normals.size(); ++i) {
      const double cosine = glm::dot(normals[i], n);
      closest[i] = j == 0 ? cosine : std::max(closest[i], cosine);
    }
  }
  return lobes;
}

}  // namespace multum
