// SPDX-License-Identifier: Apache-2.0
// Solves tiles, so that the largest maps fit into memory. Each tile is solved with kOverlap more texels on each side,
// and neighbours are blended over both overlaps. If two surfaces are within the bounds, any weighted mean of the two is
// also within the bounds.
//
//   tile 0   1 1 1 1 1 1 \ . . .
//   tile 1       . . . . / 1 1 1 1        weights along a row; the border between tiles is in the middle of the slope
#include "host/formats/image/normals/height_dequantize.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include "host/formats/image/files/number_type.h"
#include "host/formats/image/normals/thin_plate.h"
#include "host/foundation/base/processes/parallel.h"

namespace multum {
namespace {

constexpr int kTileSide = 1024;  // approximate side of a tile
constexpr int kOverlap = kDequantizeMargin;

// Divides a row or column of `count` texels into tiles. The first and the last tile also use the known texels beyond
// the sides of the image.
struct TileCuts {
  std::vector<int> cuts;  // borders between tiles, from 0 to count
  int before, after;      // numbers of known texels beyond the sides

  TileCuts(int count, bool goes_on_before, bool goes_on_after)
      : before(goes_on_before ? kOverlap : 0), after(goes_on_after ? kOverlap : 0) {
    const int tile_count = std::max(1, (count + kTileSide / 2) / kTileSide);
    for (int i = 0; i <= tile_count; ++i)
      cuts.push_back(static_cast<int>(static_cast<std::int64_t>(count) * i / tile_count));
  }
  int tile_count() const { return static_cast<int>(cuts.size()) - 1; }
  bool is_first(int tile) const { return tile == 0; }
  bool is_last(int tile) const { return tile + 1 == tile_count(); }
  int cut(int i) const { return cuts[static_cast<std::size_t>(i)]; }
  // The range of texels from which a tile is computed.
  int begin(int tile) const { return cut(tile) - (is_first(tile) ? before : kOverlap); }
  int end(int tile) const { return cut(tile + 1) + (is_last(tile) ? after : kOverlap); }
  // Returns the weight of a tile at a texel.
  float weight(int tile, int texel) const {
    const auto rise = [](int from_cut) {
      return std::clamp((static_cast<float>(from_cut + kOverlap) + 0.5f) / (2.0f * kOverlap), 0.0f, 1.0f);
    };
    float weight = 1.0f;
    if (!is_first(tile)) weight *= rise(texel - cut(tile));
    if (!is_last(tile)) weight *= 1.0f - rise(texel - cut(tile + 1));
    return weight;
  }
};

bool goes_on(const HeightSide& side) {
  return side.beyond == HeightSide::Beyond::kWrapped || side.beyond == HeightSide::Beyond::kStrip;
}

// The height beyond a side where the surface ends.
float height_beyond(const HeightSide& side) {
  return side.beyond == HeightSide::Beyond::kBlack ? 0.0f : std::numeric_limits<float>::quiet_NaN();
}

// Returns the heights of a tile in steps, relative to the first one, so that floats keep their precision for
// differences.
PlateProblem plate_of(const HeightRows& rows, int column_begin, int column_end, double step, float& first) {
  PlateProblem problem{column_end - column_begin, rows.row_count(), {}};
  problem.codes.reserve(static_cast<std::size_t>(problem.width) * static_cast<std::size_t>(problem.height));
  first = std::numeric_limits<float>::quiet_NaN();
  for (int row = rows.row_begin; row < rows.row_begin + problem.height; ++row) {
    for (int column = column_begin; column < column_end; ++column) {
      const float height = rows.at(column, row);
      if (std::isnan(first)) first = height;
      problem.codes.push_back(static_cast<float>((static_cast<double>(height) - static_cast<double>(first)) / step));
    }
  }
  return problem;
}

// A row of tiles, blended along the row. It covers texel rows [begin, end) and columns from -1 to width.
struct TileRow {
  int begin = 0, end = 0;
  std::vector<float> heights;
};

class Dequantization {
 public:
  Dequantization(const HeightSurface& surface, double step, int threads)
      : surface_(surface),
        step_(step),
        threads_(threads),
        columns_(surface.width(), goes_on(surface.sides().left), goes_on(surface.sides().right)),
        rows_(surface.height(), goes_on(surface.sides().above), goes_on(surface.sides().below)) {}

  void run(RawImage& image, Progress* progress) const {
    write_end(surface_.sides().above, -1, image);
    write_end(surface_.sides().below, surface_.height(), image);
    TileRow before;
    for (int tile = 0; tile < rows_.tile_count(); ++tile) {
      TileRow now = tile_row(tile, progress);
      if (!rows_.is_first(tile)) fade_rows(tile, before, now);
      const int begin = std::max(now.begin, -1);
      const int end = rows_.is_last(tile) ? std::min(now.end, surface_.height() + 1) : rows_.cut(tile + 1) - kOverlap;
      write_rows(begin, end - begin, &now.heights[row_size() * static_cast<std::size_t>(begin - now.begin)], image);
      before = std::move(now);
    }
  }

 private:
  std::size_t row_size() const { return static_cast<std::size_t>(surface_.width()) + 2; }

  static void write_rows(int begin, int count, const float* heights, RawImage& image) {
    image.write({begin + 1, count, reinterpret_cast<const std::byte*>(heights)});
  }

  // Writes the row beyond a side where the surface ends.
  void write_end(const HeightSide& side, int row, RawImage& image) const {
    const std::vector<float> heights(row_size(), height_beyond(side));
    if (!goes_on(side)) write_rows(row, 1, heights.data(), image);
  }

  TileRow tile_row(int tile, Progress* progress) const {
    TileRow result{rows_.begin(tile), rows_.end(tile), {}};
    const int row_count = result.end - result.begin;
    const HeightRows found = surface_.rows(result.begin, result.end, std::max(columns_.before, columns_.after));
    std::vector<std::vector<float>> solved(static_cast<std::size_t>(columns_.tile_count()));
    for_each_row_band(columns_.tile_count(), 1, threads_, progress, [&](int column, int, int) {
      float first = 0.0f;
      const PlateProblem problem = plate_of(found, columns_.begin(column), columns_.end(column), step_, first);
      std::vector<float> heights = thin_plate(problem);
      for (std::size_t i = 0; i < heights.size(); ++i)
        heights[i] = std::isnan(problem.codes[i])
                         ? problem.codes[i]
                         : static_cast<float>(static_cast<double>(first) + step_ * static_cast<double>(heights[i]));
      solved[static_cast<std::size_t>(column)] = std::move(heights);
    });
    result.heights.assign(row_size() * static_cast<std::size_t>(row_count), 0.0f);
    for (int column = 0; column < columns_.tile_count(); ++column)
      add_tile(column, solved[static_cast<std::size_t>(column)], row_count, result);
    for (std::size_t row = 0; row < static_cast<std::size_t>(row_count); ++row) {
      if (!goes_on(surface_.sides().left)) result.heights[row * row_size()] = height_beyond(surface_.sides().left);
      if (!goes_on(surface_.sides().right))
        result.heights[(row + 1) * row_size() - 1] = height_beyond(surface_.sides().right);
    }
    return result;
  }

  void add_tile(int tile, const std::vector<float>& heights, int row_count, TileRow& to) const {
    const int begin = columns_.begin(tile), end = columns_.end(tile);
    for (int row = 0; row < row_count; ++row) {
      const float* const from = &heights[static_cast<std::size_t>(row) * static_cast<std::size_t>(end - begin)];
      float* const row_of_result = &to.heights[row_size() * static_cast<std::size_t>(row)];
      for (int column = std::max(begin, -1); column < std::min(end, surface_.width() + 1); ++column)
        if (const float weight = columns_.weight(tile, column); weight > 0.0f)
          row_of_result[column + 1] += weight * from[column - begin];
    }
  }

  // Blends the first rows of a tile with the same rows of the previous tile.
  void fade_rows(int tile, const TileRow& before, TileRow& now) const {
    for (int row = now.begin; row < std::min(now.end, before.end); ++row) {
      const float weight = rows_.weight(tile, row);
      const float* const from = &before.heights[row_size() * static_cast<std::size_t>(row - before.begin)];
      float* const to = &now.heights[row_size() * static_cast<std::size_t>(row - now.begin)];
      for (std::size_t i = 0; i < row_size(); ++i) to[i] = weight * to[i] + (1.0f - weight) * from[i];
    }
  }

  const HeightSurface& surface_;
  double step_;
  int threads_;
  TileCuts columns_, rows_;
};

RawImageInfo info_of(const HeightSurface& surface) {
  RawImageInfo info = surface.info();
  info.width += 2;
  info.height += 2;
  info.channel_count = 1;
  info.sample_type = SampleType::kFloat;
  info.base_type = number_type::kFloat;
  info.row_bytes = info.row_values() * sizeof(float);
  return info;
}

}  // namespace

RawImage dequantized_heights(const HeightSurface& surface, double step, const SpillPolicy& spill, int threads,
                             Progress* progress) {
  progress_stage(progress, "dequantize heights");
  RawImage image(info_of(surface), spill);
  Dequantization(surface, step, threads).run(image, progress);
  return image;
}

}  // namespace multum
