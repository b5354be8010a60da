// SPDX-License-Identifier: Apache-2.0
#include "host/pyramid/feature_planes.h"

#include <algorithm>
#include <utility>

namespace multum {

FeaturePlanes FeaturePlanes::of(const PlaneStore* albedo, const WeightMap* weights) {
  FeaturePlanes features;
  features.has_colours = albedo != nullptr;
  if (albedo != nullptr) features.triples.push_back(albedo);
  if (weights == nullptr) return features;
  features.weight_count = weights->count;
  for (const PlaneStore& triple : weights->triples) features.triples.push_back(&triple);
  return features;
}

bool FeaturePlanes::all_of_size(int width, int height) const {
  return std::all_of(triples.begin(), triples.end(),
                     [&](const PlaneStore* triple) { return triple->width() == width && triple->height() == height; });
}

void split_features(std::vector<std::vector<glm::vec3>> triples, const FeaturePlanes& features,
                    std::vector<glm::vec3>& colours, std::vector<float>& weights) {
  const std::size_t first = features.has_colours ? 1 : 0, count = static_cast<std::size_t>(features.weight_count);
  if (features.has_colours) colours = std::move(triples[0]);
  if (count == 0) return;
  const std::size_t texels = triples[first].size();
  weights.resize(texels * count);
  for (std::size_t i = 0; i < texels; ++i)
    for (std::size_t k = 0; k < count; ++k)
      weights[i * count + k] = triples[first + k / 3][i][static_cast<glm::length_t>(k % 3)];
}

}  // namespace multum
