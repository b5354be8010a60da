// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/pyramid/feature_planes.h"

#include <algorithm>
#include <utility>

namespace multum {

FeaturePlanes FeaturePlanes::of(const PlaneStore* albedo, const WeightMap* weights) {
  FeaturePlanes features;
  features.has_colours = albedo != nullptr;
  if (albedo != nullptr) features.rgb_planes.push_back(albedo);
  if (weights == nullptr) return features;
  features.weight_count = weights->count;
  for (const PlaneStore& rgb_plane : weights->rgb_planes) features.rgb_planes.push_back(&rgb_plane);
  return features;
}

FeaturePlanes FeaturePlanes::with_colours(const PlaneStore& albedo) const {
  FeaturePlanes both = *this;
  both.has_colours = true;
  both.rgb_planes.insert(both.rgb_planes.begin(), &albedo);
  return both;
}

bool FeaturePlanes::all_of_size(int width, int height) const {
  return std::all_of(rgb_planes.begin(), rgb_planes.end(), [&](const PlaneStore* rgb_plane) {
    return rgb_plane->width() == width && rgb_plane->height() == height;
  });
}

void split_features(std::vector<std::vector<glm::vec3>> rgb_planes, const FeaturePlanes& features,
                    std::vector<glm::vec3>& colours, std::vector<float>& weights) {
  const std::size_t first = features.has_colours ? 1 : 0, count = static_cast<std::size_t>(features.weight_count);
  if (features.has_colours) colours = std::move(rgb_planes[0]);
  if (count == 0) return;
  const std::size_t texels = rgb_planes[first].size();
  weights.resize(texels * count);
  for (std::size_t i = 0; i < texels; ++i)
    for (std::size_t k = 0; k < count; ++k)
      weights[i * count + k] = rgb_planes[first + k / 3][i][static_cast<glm::length_t>(k % 3)];
}

}  // namespace multum
