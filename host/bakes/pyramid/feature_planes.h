// SPDX-License-Identifier: Apache-2.0
// Describes a map's normals and the linear features of its material, which are colours, followed by weights of basis
// BRDFs (Han et al. 2007, section 7.3). Features are averaged or divided among lobes together with the normals. Every
// bake treats features as triples of planes, regardless of their meaning.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/image/material_maps.h"
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

struct FeaturePlanes {
  std::vector<const PlaneStore*> rgb_planes;
  bool has_colours = false;  // colours are the first triple
  int weight_count = 0;      // number of weights in the triples after the colours

  /// `albedo` and `weights` may be null. They must outlive the result.
  static FeaturePlanes of(const PlaneStore* albedo, const WeightMap* weights);
  /// Returns these features with colours in front. `albedo` must outlive the result. There must be no colours yet.
  FeaturePlanes with_colours(const PlaneStore& albedo) const;

  bool empty() const { return rgb_planes.empty(); }
  int rgb_plane_count() const { return static_cast<int>(rgb_planes.size()); }
  bool all_of_size(int width, int height) const;
};

/// The inputs and limits of a bake. PlaneStore::is_shortened() of the normals states whether roughness is included.
struct MapInputs {
  const PlaneStore* normals = nullptr;
  FeaturePlanes features = {};                          // features of the map's size
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // memory for windows and buffers; does not change the result
  int threads = 1;                                      // number of threads for loops on the host
  std::uint64_t writer_bytes = 0;              // part of memory_bytes that the writer uses while levels are fitted
  SpillPolicy spill{.memory_bytes = 4 << 20};  // policy for rows that the next level needs
};

/// Splits features [triple][texel] into colours and weights, texel by texel, as in the file.
void split_features(std::vector<std::vector<glm::vec3>> rgb_planes, const FeaturePlanes& features,
                    std::vector<glm::vec3>& colours, std::vector<float>& weights);

}  // namespace multum
