// SPDX-License-Identifier: Apache-2.0
// Launches movmf_feature_partial on a small map. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/lab/selftest/em_launch.h"

namespace multum {

/// A map and the level that is fitted: at most MULTUM_GROUP texels, the first slots.
struct FeatureMap {
  int width, height, level_width, level_height;
  int chunk_rows, chunk_count;             // of a texel's rows
  std::vector<glm::vec3> normals, values;  // [row][column]
};

/// Sums of the values by lobes, [slot][chunk, then lobe]; of slots without a texel NaN. `texels`: the lobes of the
/// slots; where there are fewer, they begin again.
std::vector<std::vector<glm::vec3>> feature_partials(Device& device, const FeatureMap& map,
                                                     const std::vector<EmTexel>& texels);

}  // namespace multum
