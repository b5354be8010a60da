// SPDX-License-Identifier: Apache-2.0
// Makes a small map that behaves like a large map, so that settings can be tried at low cost. The large map is divided
// into as many cells as the mosaic has blocks. From each cell, one block at a random place is copied to the cell's
// position in the mosaic. Fine levels of the mosaic are therefore samples of the map's levels. At coarse levels, blocks
// have the same neighbours as in the map.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/vec2.hpp>

#include "host/formats/image/plane_store.h"

namespace multum {

struct MosaicSettings {
  int side_max = 256;  // maximum side in texels; smaller maps are copied whole
  int block = 64;      // texels per side, a divisor of side_max; levels 0..6 of a block equal those of the map
  std::uint64_t seed = 1;
};

/// The size of a mosaic, and where its blocks are in the map.
struct MosaicCuts {
  int width, height;
  std::vector<std::vector<glm::ivec2>> blocks;  // first texel, by block row and block column
};

/// Divides a map of this size into cells and takes one block of each.
MosaicCuts mosaic_cuts(int width, int height, const MosaicSettings& settings);
/// Copies the blocks to a store in memory.
PlaneStore cut_planes(const PlaneStore& map, const MosaicCuts& cuts);

/// The mosaic of a map and of its material.
struct MapMosaic {
  PlaneStore normals;
  std::optional<PlaneStore> material = std::nullopt;  // alpha^2, occlusion and metalness
  int map_width = 0, map_height = 0;
};

/// The mosaic that a bake or an export keeps, to measure the map's gain at low cost.
constexpr MosaicSettings kSmallMosaic{128, 32, 1};

/// Makes the mosaic of normals and, unless it is null, of the material.
MapMosaic mosaic_of(const PlaneStore& normals, const PlaneStore* material, const MosaicSettings& settings);

}  // namespace multum
