// SPDX-License-Identifier: Apache-2.0
// A map's normals, and linear features of a material that go along with its normals, averaged or shared out among
// lobes: colours, then weights of basis BRDFs (Han et al. 2007, section 7.3). Every bake takes them as planes by
// threes, whatever they mean.
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
  bool has_colours = false;  // the first triple
  int weight_count = 0;      // in those after it

  /// `albedo` and `weights` may be null, and must outlive it.
  static FeaturePlanes of(const PlaneStore* albedo, const WeightMap* weights);
  /// These, behind colours. `albedo` must outlive them; there were no colours yet.
  FeaturePlanes with_colours(const PlaneStore& albedo) const;

  bool empty() const { return rgb_planes.empty(); }
  int rgb_plane_count() const { return static_cast<int>(rgb_planes.size()); }
  bool all_of_size(int width, int height) const;
};

/// What a bake reads, and what it may use. Roughness is told by the normals (PlaneStore::is_shortened()).
struct MapInputs {
  const PlaneStore* normals = nullptr;
  FeaturePlanes features = {};                          // of the same size
  std::uint64_t memory_bytes = std::uint64_t{1} << 30;  // for windows and buffers; changes no byte of the result
  int threads = 1;                                      // of the host's own loops
  std::uint64_t writer_bytes = 0;              // of memory_bytes, what the writer holds while levels are fitted
  SpillPolicy spill{.memory_bytes = 4 << 20};  // of what one level leaves for the next
};

/// Features of some texels, [triple][texel], as files have them: colours, and weights texel by texel.
void split_features(std::vector<std::vector<glm::vec3>> rgb_planes, const FeaturePlanes& features,
                    std::vector<glm::vec3>& colours, std::vector<float>& weights);

}  // namespace multum
