// SPDX-License-Identifier: Apache-2.0
// Launches movmf_feature_partial on a small map. Private to host/lab/selftest and its tests.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/lab/selftest/em_launch.h"

namespace multum {

/// A map and its fitted level. The level has at most MULTUM_GROUP texels, which are in the first slots of a group.
struct FeatureMap {
  int width, height, level_width, level_height;
  int chunk_rows, chunk_count;             // size and number of the chunks into which the rows of a texel are divided
  std::vector<glm::vec3> normals, values;  // [row][column]
};

/// For each lobe, returns the sum of the values that belong to the lobe, as [slot][chunk, then lobe]. Slots without a
/// texel are NaN. `texels` contains the lobes of the slots, and is repeated if there are more slots.
std::vector<std::vector<glm::vec3>> feature_partials(Device& device, const FeatureMap& map,
                                                     const std::vector<EmTexel>& texels);

}  // namespace multum
