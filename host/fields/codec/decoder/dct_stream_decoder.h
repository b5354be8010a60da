// SPDX-License-Identifier: Apache-2.0
// Decodes the images of a pyramid over parameters from one stream. It first decodes the cosine coefficients of square
// blocks (dct_syntax.h), and then computes samples. All images share contexts, so a stream is decoded from its
// beginning. An image's samples are computed only on request.
#pragma once

#include <cstddef>
#include <optional>

#include "host/fields/codec/decoder/dct_syntax.h"
#include "host/fields/codec/decoder/decoding_limits.h"

namespace multum {

/// The blocks of an image, row by row. Blocks at the right and lower borders extend beyond the image.
struct BlockGrid {
  std::size_t width = 1, height = 1;  // samples
  std::size_t side = 16;              // side of a block: 8, 16 or 32

  std::size_t columns() const { return (width + side - 1) / side; }
  std::size_t rows() const { return (height + side - 1) / side; }
  std::size_t count() const { return columns() * rows(); }
};

/// The groups of 4 x 4 blocks in which blocks are coded, row by row. The groups at the right and lower borders are
/// smaller. Most groups of most images are empty.
class BlockGroups {
 public:
  explicit BlockGroups(const BlockGrid& grid);

  std::size_t count() const { return numbers_.size(); }
  /// Returns the numbers of a group's blocks, row by row.
  std::span<const std::size_t> blocks(std::size_t group) const { return numbers_[group]; }
  /// Returns the surroundings of a group in `image`. `before` is the image that was coded before `image`. `parent` and
  /// `before` may be null.
  GroupSurroundings surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent,
                                 const CoefficientBlocks* before, std::size_t plane, std::size_t group,
                                 std::size_t level) const;

 private:
  static constexpr std::size_t kSide = 4;

  bool has_any(const CoefficientBlocks* image, std::size_t plane, std::size_t group) const;

  std::size_t columns_;
  std::vector<std::vector<std::size_t>> numbers_;
};

/// Returns the surroundings of block `number` in `plane` of `image`. `parent` may be null.
BlockSurroundings surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent, const BlockGrid& grid,
                               std::size_t plane, std::size_t number, std::size_t level);

/// Returns the prediction of a block's constant in an image without a parent. The prediction is the mean of the
/// constants of the blocks to the left and above, if these exist.
int predicted_constant(const CoefficientBlocks& image, const BlockGrid& grid, std::size_t plane, std::size_t number);

class DctStreamDecoder {
 public:
  /// The bytes and the limits must outlive the decoder.
  DctStreamDecoder(const BlockGrid& grid, std::span<const std::uint8_t> bytes, DecodingAccount* account = nullptr)
      : grid_(grid),
        groups_(grid),
        syntax_(static_cast<int>(grid.side)),
        port_(bytes),
        coder_(port_),
        account_(account) {}
  DctStreamDecoder(const DctStreamDecoder&) = delete;
  DctStreamDecoder& operator=(const DctStreamDecoder&) = delete;

  /// Decodes the stream's next image. `parent` is an earlier image that this image refines, or null. `before` is the
  /// image decoded last, or null for the first image. After the end of the stream, or if a limit stops decoding, all
  /// coefficients are zero.
  CoefficientBlocks next_image(const CoefficientBlocks* parent, const CoefficientBlocks* before, std::size_t level);

  /// Returns whether the stream ended before all its images were decoded.
  bool exhausted() const { return port_.exhausted(); }

 private:
  /// Returns false if the stream ended or a limit stopped it.
  bool add_plane(CoefficientBlocks& image, const CoefficientBlocks* parent, const CoefficientBlocks* before,
                 std::size_t plane, std::size_t level);

  BlockGrid grid_;
  BlockGroups groups_;
  DctSyntax syntax_;
  DecodingPort port_;
  SymbolCoder<DecodingPort> coder_;
  AdaptiveBit empty_plane_;
  DecodingAccount* account_;
};

/// An image and the factor by which it is multiplied.
struct WeighedImage {
  const CoefficientBlocks* image;
  float scale;
};

/// Adds the images' sum to `colours`, [height][width][3]. Multiplies the coefficients by `steps`, which has one step
/// per place of a block, and transforms them back. Plane p is multiplied by the colour in row p of `rows`. Adds the
/// images before the transform, so that only one transform is needed. Skips blocks of zeros.
void add_colours(std::span<const WeighedImage> images, const BlockGrid& grid, std::span<const float> steps,
                 const std::array<std::array<float, 3>, 3>& rows, std::span<float> colours);

}  // namespace multum
