// SPDX-License-Identifier: Apache-2.0
#include "host/codec/decoder/dct_stream_decoder.h"

#include "host/codec/decoder/block_dct.h"

namespace multum {

namespace {

struct BlockPlace {
  std::size_t number, column, columns;  // columns in all
};

/// `surroundings` without its divisions, which take longer than a block of zeros otherwise does.
BlockSurroundings surroundings_at(const CoefficientBlocks& image, const CoefficientBlocks* parent,
                                  const BlockPlace& place, std::size_t plane, std::size_t level) {
  const std::size_t number = place.number;
  BlockSurroundings around;
  if (place.column > 0) around.left = image.block(plane, number - 1);
  if (number >= place.columns) around.up = image.block(plane, number - place.columns);
  if (parent != nullptr) around.parent = parent->block(plane, number);
  if (plane > 0) around.luma = image.block(0, number);
  around.has_parent = parent != nullptr;
  around.plane = plane;
  around.level = level;
  return around;
}

}  // namespace

BlockSurroundings surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent, const BlockGrid& grid,
                               std::size_t plane, std::size_t number, std::size_t level) {
  const std::size_t columns = grid.columns();
  return surroundings_at(image, parent, {number, number % columns, columns}, plane, level);
}

int predicted_constant(const CoefficientBlocks& image, const BlockGrid& grid, std::size_t plane, std::size_t number) {
  const auto constant = [&](std::size_t n) -> int {
    const auto values = image.block(plane, n);
    return values.empty() ? 0 : values[0];
  };
  const bool has_left = number % grid.columns() > 0, has_up = number >= grid.columns();
  if (has_left && has_up) return (constant(number - 1) + constant(number - grid.columns())) / 2;
  if (has_left) return constant(number - 1);
  return has_up ? constant(number - grid.columns()) : 0;
}

CoefficientBlocks DctStreamDecoder::next_image(const CoefficientBlocks* parent, std::size_t level) {
  CoefficientBlocks image(grid_.count(), grid_.side * grid_.side);
  std::vector<std::int16_t> values(grid_.side * grid_.side);
  for (std::size_t plane = 0; plane < CoefficientBlocks::kPlanes; ++plane) {
    if (coder_.bit(false, empty_plane_)) continue;
    const std::size_t columns = grid_.columns(), count = grid_.count();
    for (std::size_t number = 0, column = 0; number < count; ++number, column = column + 1 < columns ? column + 1 : 0) {
      // Three times: a vector that grows holds its old and its new room, twice as large, for a moment.
      if (account_ != nullptr && account_->is_over(3 * image.memory_bytes())) return image;
      const bool is_coded =
          syntax_.block(coder_, values, surroundings_at(image, parent, {number, column, columns}, plane, level));
      if (port_.exhausted()) return image;  // of this block something may be made up
      if (!is_coded && parent != nullptr) continue;
      if (parent == nullptr)
        values[0] =
            static_cast<std::int16_t>(std::clamp(values[0] + predicted_constant(image, grid_, plane, number),
                                                 -CoefficientBlocks::kMagnitudeMax, CoefficientBlocks::kMagnitudeMax));
      if (std::any_of(values.begin(), values.end(), [](auto value) { return value != 0; }))
        std::copy(values.begin(), values.end(), image.make(plane, number).begin());
      std::fill(values.begin(), values.end(), std::int16_t{0});
    }
  }
  return image;
}

void add_samples(std::span<const WeighedImage> images, const BlockGrid& grid, std::size_t plane,
                 std::span<const float> steps, std::span<float> samples) {
  std::vector<float> block(grid.side * grid.side);
  for (std::size_t number = 0; number < grid.count(); ++number) {
    bool is_zero = true;
    for (const WeighedImage& weighed : images) {
      const auto values = weighed.image->block(plane, number);
      if (values.empty()) continue;
      if (is_zero) std::fill(block.begin(), block.end(), 0.0f);
      is_zero = false;
      for (std::size_t i = 0; i < block.size(); ++i)
        block[i] += weighed.scale * steps[i] * static_cast<float>(values[i]);
    }
    if (is_zero) continue;
    inverse_dct(static_cast<int>(grid.side), block, block);
    const std::size_t left = number % grid.columns() * grid.side, top = number / grid.columns() * grid.side;
    for (std::size_t y = 0; y < std::min(grid.side, grid.height - top); ++y)
      for (std::size_t x = 0; x < std::min(grid.side, grid.width - left); ++x)
        samples[(top + y) * grid.width + left + x] += block[y * grid.side + x];
  }
}

}  // namespace multum
