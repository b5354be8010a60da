// SPDX-License-Identifier: Apache-2.0
// Decodes the images of a pyramid over parameters from one stream: cosine coefficients of square blocks (dct_syntax.h),
// and samples from them. Image after image shares contexts, so a stream is decoded from its begin; an image's samples
// are made only when they are wanted.
#pragma once

#include <cstddef>
#include <optional>

#include "host/fields/codec/decoder/dct_syntax.h"
#include "host/fields/codec/decoder/decoding_limits.h"

namespace multum {

/// Blocks of an image, rows of blocks after one another; those at the right and lower borders reach beyond it.
struct BlockGrid {
  std::size_t width = 1, height = 1;  // samples
  std::size_t side = 16;              // of a block: 8, 16 or 32

  std::size_t columns() const { return (width + side - 1) / side; }
  std::size_t rows() const { return (height + side - 1) / side; }
  std::size_t count() const { return columns() * rows(); }
};

/// The groups in which blocks are coded, 4 x 4 of them, fewer at the right and lower borders; rows of groups after one
/// another. Most groups of most images have nothing.
class BlockGroups {
 public:
  explicit BlockGroups(const BlockGrid& grid);

  std::size_t count() const { return numbers_.size(); }
  /// Numbers of a group's blocks, row by row.
  std::span<const std::size_t> blocks(std::size_t group) const { return numbers_[group]; }
  /// What of `image` is around a group; `parent` and `before`, the image coded before it, may be null.
  GroupSurroundings surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent,
                                 const CoefficientBlocks* before, std::size_t plane, std::size_t group,
                                 std::size_t level) const;

 private:
  static constexpr std::size_t kSide = 4;

  bool has_any(const CoefficientBlocks* image, std::size_t plane, std::size_t group) const;

  std::size_t columns_;
  std::vector<std::vector<std::size_t>> numbers_;
};

/// What of `image` is around its block `number` of `plane`; `parent` may be null.
BlockSurroundings surroundings(const CoefficientBlocks& image, const CoefficientBlocks* parent, const BlockGrid& grid,
                               std::size_t plane, std::size_t number, std::size_t level);

/// The constant that a block of an image without a parent is written against: the mean of those to the left and above,
/// where these are there.
int predicted_constant(const CoefficientBlocks& image, const BlockGrid& grid, std::size_t plane, std::size_t number);

class DctStreamDecoder {
 public:
  /// The bytes must outlive the decoder, and so must the limits.
  DctStreamDecoder(const BlockGrid& grid, std::span<const std::uint8_t> bytes, DecodingAccount* account = nullptr)
      : grid_(grid),
        groups_(grid),
        syntax_(static_cast<int>(grid.side)),
        port_(bytes),
        coder_(port_),
        account_(account) {}
  DctStreamDecoder(const DctStreamDecoder&) = delete;
  DctStreamDecoder& operator=(const DctStreamDecoder&) = delete;

  /// The stream's next image. `parent`: an image decoded before, which it refines; null for one that refines none.
  /// `before`: the one decoded last; null for the first. From where the stream ends, or limits stop it, all is zero.
  CoefficientBlocks next_image(const CoefficientBlocks* parent, const CoefficientBlocks* before, std::size_t level);

  /// The stream ended before its images did.
  bool exhausted() const { return port_.exhausted(); }

 private:
  /// False where the stream ended, or limits stopped it.
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

/// An image and what it is multiplied by.
struct WeighedImage {
  const CoefficientBlocks* image;
  float scale;
};

/// Adds the images' sum to `colours`, [height][width][3]: inverse transforms of coefficients times `steps`, one for
/// each place of a block, plane p times row p of `rows`. Images are added before they are transformed, once for all;
/// blocks of zeros take no time.
void add_colours(std::span<const WeighedImage> images, const BlockGrid& grid, std::span<const float> steps,
                 const std::array<std::array<float, 3>, 3>& rows, std::span<float> colours);

}  // namespace multum
