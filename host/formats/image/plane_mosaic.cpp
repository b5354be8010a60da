// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/plane_mosaic.h"

#include <algorithm>

#include "host/foundation/base/error.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

// If there is room, blocks begin at multiples of this value, so that mip texels cut fine patterns at the same places as
// in the map.
constexpr int kAlignment = 16;

// Returns a position in cell i of `count` cells.
int place_in_cell(int i, int count, int size, int block, std::uint64_t random) {
  const auto edge = [&](int cell) { return static_cast<int>(static_cast<std::int64_t>(size) * cell / count); };
  const int first = (edge(i) + kAlignment - 1) / kAlignment * kAlignment, last = edge(i + 1) - block;
  if (last < first) return std::min(edge(i), size - block);
  return first + kAlignment * static_cast<int>(random % static_cast<unsigned>((last - first) / kAlignment + 1));
}

}  // namespace

MosaicCuts mosaic_cuts(int width, int height, const MosaicSettings& settings) {
  MULTUM_CHECK(settings.side_max % settings.block == 0);
  // A side that is not longer than the mosaic becomes one block.
  const auto count = [&](int size) { return size <= settings.side_max ? 1 : settings.side_max / settings.block; };
  const auto side = [&](int size) { return std::min(size, settings.side_max); };
  MosaicCuts cuts{side(width), side(height), {}};
  SplitMix64 random(settings.seed);
  const int columns = count(width), rows = count(height);
  // Blocks in one row of cells use the same rows of the map, so that a map on disk is read in whole rows.
  for (int j = 0; j < rows; ++j) {
    const int y = place_in_cell(j, rows, height, cuts.height / rows, random.next());
    cuts.blocks.emplace_back();
    for (int i = 0; i < columns; ++i)
      cuts.blocks.back().emplace_back(place_in_cell(i, columns, width, cuts.width / columns, random.next()), y);
  }
  return cuts;
}

PlaneStore cut_planes(const PlaneStore& map, const MosaicCuts& cuts) {
  PlaneStore mosaic(cuts.width, cuts.height);
  mosaic.set_shortened(map.is_shortened());
  const int block_rows = cuts.height / static_cast<int>(cuts.blocks.size());
  const auto map_width = static_cast<std::size_t>(map.width()), width = static_cast<std::size_t>(cuts.width);
  std::vector<float> from(3 * map_width), to(3 * width);
  for (int y = 0; y < cuts.height; ++y) {
    const std::vector<glm::ivec2>& blocks = cuts.blocks[static_cast<std::size_t>(y / block_rows)];
    const std::size_t block_width = width / blocks.size();
    int read = -1;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const int row = blocks[i].y + y % block_rows;
      if (row != read) map.read_rows(row, 1, {from.data(), from.data() + map_width, from.data() + 2 * map_width});
      read = row;
      for (std::size_t plane = 0; plane < 3; ++plane)
        std::copy_n(from.data() + plane * map_width + static_cast<std::size_t>(blocks[i].x), block_width,
                    to.data() + plane * width + i * block_width);
    }
    mosaic.write_rows(y, 1, {to.data(), to.data() + width, to.data() + 2 * width});
  }
  return mosaic;
}

MapMosaic mosaic_of(const PlaneStore& normals, const PlaneStore* material, const MosaicSettings& settings) {
  const MosaicCuts cuts = mosaic_cuts(normals.width(), normals.height(), settings);
  MapMosaic made{cut_planes(normals, cuts)};
  if (material != nullptr) made.material.emplace(cut_planes(*material, cuts));
  made.map_width = normals.width();
  made.map_height = normals.height();
  return made;
}

}  // namespace multum
