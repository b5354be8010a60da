// SPDX-License-Identifier: Apache-2.0
// Linear features of a material that go along with its normals, averaged or shared out among lobes: colours, then
// weights of basis BRDFs (Han et al. 2007, section 7.3). Every bake takes them as planes by threes, whatever they mean.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/image/material_maps.h"
#include "host/image/plane_store.h"

namespace multum {

struct FeaturePlanes {
  std::vector<const PlaneStore*> rgb_planes;
  bool has_colours = false;  // the first triple
  int weight_count = 0;      // in those after it

  /// `albedo` and `weights` may be null, and must outlive it.
  static FeaturePlanes of(const PlaneStore* albedo, const WeightMap* weights);

  bool empty() const { return rgb_planes.empty(); }
  int rgb_plane_count() const { return static_cast<int>(rgb_planes.size()); }
  bool all_of_size(int width, int height) const;
};

/// Features of some texels, [triple][texel], as files have them: colours, and weights texel by texel.
void split_features(std::vector<std::vector<glm::vec3>> rgb_planes, const FeaturePlanes& features,
                    std::vector<glm::vec3>& colours, std::vector<float>& weights);

}  // namespace multum
