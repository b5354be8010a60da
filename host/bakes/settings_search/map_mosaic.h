// SPDX-License-Identifier: Apache-2.0
// Makes a small map that behaves like a large map, so that settings can be tried at low cost. The large map is divided
// into as many cells as the mosaic has blocks. From each cell, one block at a random place is copied to the cell's
// position in the mosaic. Fine levels of the mosaic are therefore samples of the map's levels. At coarse levels, blocks
// have the same neighbours as in the map.
#pragma once

#include <cstdint>

#include "host/bakes/bake/bake_source.h"

namespace multum {

struct MosaicSettings {
  int side_max = 256;  // maximum side in texels; smaller maps are copied whole
  int block = 64;      // texels per side, a divisor of side_max; levels 0..6 of a block equal those of the map
  std::uint64_t seed = 1;
};

/// Makes the mosaic in memory. Blocks of feature maps are taken from the same places as blocks of the normals.
BakeSource make_mosaic(const BakeSource& source, const MosaicSettings& settings);

}  // namespace multum
