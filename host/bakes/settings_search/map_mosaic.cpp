// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/map_mosaic.h"

#include <algorithm>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/split_mix.h"

namespace multum {
namespace {

// If there is room, blocks begin at multiples of this value, so that mip texels cut fine patterns at the same places as
// in the map.
constexpr int kAlignment = 16;

// The positions of the blocks in the map. Blocks in one row of cells use the same rows of the map, so that a map on
// disk is read in whole rows.
struct Cuts {
  int width, height;                // size of the mosaic
  std::vector<int> rows;            // [block row]
  std::vector<std::vector<int>> x;  // [block row][block column]
};

// Returns a position in cell i of `count` cells.
int place_in_cell(int i, int count, int size, int block, std::uint64_t random) {
  const auto edge = [&](int cell) { return static_cast<int>(static_cast<std::int64_t>(size) * cell / count); };
  const int first = (edge(i) + kAlignment - 1) / kAlignment * kAlignment, last = edge(i + 1) - block;
  if (last < first) return std::min(edge(i), size - block);
  return first + kAlignment * static_cast<int>(random % static_cast<unsigned>((last - first) / kAlignment + 1));
}

Cuts make_cuts(int width, int height, const MosaicSettings& settings) {
  // A side that is not longer than the mosaic becomes one block.
  const auto count = [&](int size) { return size <= settings.side_max ? 1 : settings.side_max / settings.block; };
  const auto side = [&](int size) { return std::min(size, settings.side_max); };
  Cuts cuts{side(width), side(height), {}, {}};
  SplitMix64 random(settings.seed);
  const int columns = count(width), rows = count(height);
  for (int j = 0; j < rows; ++j) {
    cuts.rows.push_back(place_in_cell(j, rows, height, cuts.height / rows, random.next()));
    cuts.x.emplace_back();
    for (int i = 0; i < columns; ++i)
      cuts.x.back().push_back(place_in_cell(i, columns, width, cuts.width / columns, random.next()));
  }
  return cuts;
}

PlaneStore cut_planes(const PlaneStore& map, const Cuts& cuts) {
  PlaneStore mosaic(cuts.width, cuts.height);
  mosaic.set_shortened(map.is_shortened());
  const auto block_rows = cuts.height / static_cast<int>(cuts.rows.size());
  const auto map_width = static_cast<std::size_t>(map.width());
  std::vector<float> from(3 * map_width), to(3 * static_cast<std::size_t>(cuts.width));
  for (int y = 0; y < cuts.height; ++y) {
    const auto j = static_cast<std::size_t>(y / block_rows);
    map.read_rows(cuts.rows[j] + y % block_rows, 1,
                  {from.data(), from.data() + map_width, from.data() + 2 * map_width});
    float* next = to.data();
    for (std::size_t plane = 0; plane < 3; ++plane)
      for (const int x : cuts.x[j])
        next = std::copy_n(from.data() + plane * map_width + static_cast<std::size_t>(x),
                           static_cast<std::size_t>(cuts.width) / cuts.x[j].size(), next);
    const auto width = static_cast<std::size_t>(cuts.width);
    mosaic.write_rows(y, 1, {to.data(), to.data() + width, to.data() + 2 * width});
  }
  return mosaic;
}

}  // namespace

BakeSource make_mosaic(const BakeSource& source, const MosaicSettings& settings) {
  MULTUM_CHECK(settings.side_max % settings.block == 0);
  const PlaneStore& normals = source.map.normals;
  const Cuts cuts = make_cuts(normals.width(), normals.height(), settings);
  BakeSource mosaic{{cut_planes(normals, cuts), source.map.report}, std::nullopt, std::nullopt};
  if (source.albedo) mosaic.albedo.emplace(cut_planes(*source.albedo, cuts));
  if (source.weights) {
    mosaic.weights.emplace();
    mosaic.weights->count = source.weights->count;
    for (const PlaneStore& rgb_plane : source.weights->rgb_planes)
      mosaic.weights->rgb_planes.push_back(cut_planes(rgb_plane, cuts));
  }
  mosaic.mean_cosine = source.mean_cosine;
  return mosaic;
}

}  // namespace multum
