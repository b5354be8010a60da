// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/dct_stream_decoder.h"

#include "host/fields/codec/decoder/block_dct.h"

namespace multum {

BlockGroups::BlockGroups(const BlockGrid& grid) : columns_((grid.columns() + kSide - 1) / kSide) {
  numbers_.resize(columns_ * ((grid.rows() + kSide - 1) / kSide));
  for (std::size_t number = 0; number < grid.count(); ++number)
    numbers_[number / grid.columns() / kSide * columns_ + number % grid.columns() / kSide].push_back(number);
}

bool BlockGroups::has_any(const CoefficientBlocks* image, std::size_t plane, std::size_t group) const {
  if (image == nullptr || !image->has_plane(plane)) return false;
  const auto blocks = this->blocks(group);
  return std::any_of(blocks.begin(), blocks.end(), [&](auto number) { return !image->block(plane, number).empty(); });
}

GroupSurroundings BlockGroups::surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent,
                                            const CoefficientBlocks* before, std::size_t plane, std::size_t group,
                                            std::size_t level) const {
  GroupSurroundings around;
  around.beside = (group % columns_ > 0 && has_any(&image, plane, group - 1) ? 1u : 0u) +
                  (group >= columns_ && has_any(&image, plane, group - columns_) ? 1u : 0u);
  around.has_parent = parent != nullptr;
  around.parent = has_any(parent, plane, group);
  around.before = has_any(before, plane, group);
  around.luma = plane > 0 && has_any(&image, 0, group);
  around.plane = plane;
  around.level = level;
  return around;
}

BlockSurroundings surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent, const BlockGrid& grid,
                               std::size_t plane, std::size_t number, std::size_t level) {
  const std::size_t columns = grid.columns();
  BlockSurroundings around;
  if (number % columns > 0) around.left = image.block(plane, number - 1);
  if (number >= columns) around.up = image.block(plane, number - columns);
  if (parent != nullptr) around.parent = parent->block(plane, number);
  if (plane > 0) around.luma = image.block(0, number);
  around.has_parent = parent != nullptr;
  around.plane = plane;
  around.level = level;
  return around;
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

bool DctStreamDecoder::add_plane(CoefficientBlocks& image, const CoefficientBlocks* parent,
                                 const CoefficientBlocks* before, std::size_t plane, std::size_t level) {
  if (coder_.bit(false, empty_plane_)) return true;
  std::vector<std::int16_t> values(grid_.side * grid_.side);
  for (std::size_t group = 0; group < groups_.count(); ++group) {
    const bool has_any = syntax_.group(coder_, false, groups_.surroundings(image, parent, before, plane, group, level));
    if (port_.exhausted()) return false;
    if (!has_any && parent != nullptr) continue;
    bool any_yet = false;
    for (const std::size_t number : groups_.blocks(group)) {
      // The factor is 3 because a growing vector briefly holds its old storage and a new one of twice the size.
      if (account_ != nullptr && account_->is_over(3 * image.memory_bytes())) return false;
      const bool is_only = !any_yet && number == groups_.blocks(group).back();
      const bool is_coded =
          has_any && syntax_.block(coder_, values, surroundings(image, parent, grid_, plane, number, level), is_only);
      if (port_.exhausted()) return false;  // parts of this block may be wrong
      any_yet |= is_coded;
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
  return true;
}

CoefficientBlocks DctStreamDecoder::next_image(const CoefficientBlocks* parent, const CoefficientBlocks* before,
                                               std::size_t level) {
  CoefficientBlocks image(grid_.count(), grid_.side * grid_.side);
  for (std::size_t plane = 0; plane < CoefficientBlocks::kPlanes; ++plane)
    if (!add_plane(image, parent, before, plane, level)) break;
  return image;
}

namespace {

/// Computes the samples of a block in a plane of the images' sum. If all samples are zero, returns false and does not
/// change `samples`.
bool summed_block(std::span<const WeighedImage> images, const BlockGrid& grid, std::size_t plane, std::size_t number,
                  std::span<const float> steps, std::span<float> samples) {
  bool is_zero = true;
  for (const WeighedImage& weighed : images) {
    const auto values = weighed.image->block(plane, number);
    if (values.empty()) continue;
    if (is_zero) std::fill(samples.begin(), samples.end(), 0.0f);
    is_zero = false;
    for (std::size_t i = 0; i < samples.size(); ++i)
      samples[i] += weighed.scale * steps[i] * static_cast<float>(values[i]);
  }
  if (!is_zero) inverse_dct(static_cast<int>(grid.side), samples, samples);
  return !is_zero;
}

}  // namespace

void add_colours(std::span<const WeighedImage> images, const BlockGrid& grid, std::span<const float> steps,
                 const std::array<std::array<float, 3>, 3>& rows, std::span<float> colours) {
  std::vector<float> block(grid.side * grid.side);
  for (std::size_t number = 0; number < grid.count(); ++number) {
    const std::size_t left = number % grid.columns() * grid.side, top = number / grid.columns() * grid.side;
    const std::size_t width = std::min(grid.side, grid.width - left), height = std::min(grid.side, grid.height - top);
    for (std::size_t p = 0; p < CoefficientBlocks::kPlanes; ++p) {
      if (!summed_block(images, grid, p, number, steps, block)) continue;
      for (std::size_t y = 0; y < height; ++y) {
        const std::span<float> line = colours.subspan(3 * ((top + y) * grid.width + left), 3 * width);
        for (std::size_t x = 0; x < width; ++x)
          for (std::size_t c = 0; c < 3; ++c) line[3 * x + c] += rows[p][c] * block[y * grid.side + x];
      }
    }
  }
}

}  // namespace multum
