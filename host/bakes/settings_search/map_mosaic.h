// SPDX-License-Identifier: Apache-2.0
// Makes a small map that behaves like a large one: the large map is cut into as many cells as the mosaic has blocks,
// and of each cell one block, at a random place, stands in the mosaic where the cell stands in the map. Fine levels of
// the mosaic then are samples of the map's own, and coarse ones see neighbours that are neighbours in the map as well,
// so that settings can be tried on it at a part of the cost.
#pragma once

#include <cstdint>

#include "host/bakes/bake/bake_source.h"

namespace multum {

struct MosaicSettings {
  int side_max = 256;  // texels; a map that is no larger is taken whole
  int block = 64;      // texels a side, divides side_max: levels 0..6 of a block are the map's
  std::uint64_t seed = 1;
};

/// In memory. Maps that go along with the normals are cut in the same places.
BakeSource make_mosaic(const BakeSource& source, const MosaicSettings& settings);

}  // namespace multum
