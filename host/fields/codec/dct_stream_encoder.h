// SPDX-License-Identifier: Apache-2.0
// Encodes the images of a pyramid over parameters into the stream that DctStreamDecoder reads. The encoder chooses
// coefficients by rate and distortion. For each block, it tries to drop bands and to lower each coefficient by one
// step, and keeps the choice with the least error + lambda bits. The number of bits is estimated from the contexts.
#pragma once

#include "host/fields/codec/coding_ports.h"
#include "host/fields/codec/decoder/dct_stream_decoder.h"

namespace multum {

/// The target coefficients of an image, and their required precision.
struct DctTarget {
  /// The target coefficients per plane, block by block. There are grid.count() * side * side values.
  std::array<std::vector<float>, CoefficientBlocks::kPlanes> coefficients;
  /// The weight of each coefficient's squared error, block by block. Weights are at least 0, and 0 for invisible
  /// coefficients.
  std::vector<float> weights;
  std::vector<float> steps;  // steps above 0, one per position in a block
  float scale = 1.0f;        // multiplies all steps
  float lambda = 0.0f;       // the weighted squared error that justifies one bit
};

class DctStreamEncoder {
 public:
  explicit DctStreamEncoder(const BlockGrid& grid)
      : grid_(grid), groups_(grid), syntax_(static_cast<int>(grid.side)), coder_(port_) {}
  DctStreamEncoder(const DctStreamEncoder&) = delete;
  DctStreamEncoder& operator=(const DctStreamEncoder&) = delete;

  /// Codes the next image and returns the image that the decoder will have. `parent`, `before` and `level` are as in
  /// the decoder.
  CoefficientBlocks add_image(const DctTarget& target, const CoefficientBlocks* parent, const CoefficientBlocks* before,
                              std::size_t level);

  std::size_t bits() const { return port_.bits(); }
  /// Ends the stream. Nothing may be added afterwards.
  std::vector<std::uint8_t> finish() { return port_.finish(); }

 private:
  using Values = std::vector<std::int16_t>;

  /// The level of an image, and the images from which it is predicted.
  struct ImagePlace {
    const CoefficientBlocks *parent, *before;
    std::size_t level;
  };

  void add_plane(CoefficientBlocks& image, const DctTarget& target, const ImagePlace& place, std::size_t plane);
  Values chosen_values(const DctTarget& target, std::size_t plane, std::size_t number, int constant,
                       const BlockSurroundings& around, float bits_if_any);
  float opening_bits(const GroupSurroundings& around);
  float bits_of(Values& values, const BlockSurroundings& around);

  BlockGrid grid_;
  BlockGroups groups_;
  DctSyntax syntax_;
  EncodingPort port_;
  SymbolCoder<EncodingPort> coder_;
  AdaptiveBit empty_plane_;
};

/// Returns the cosine coefficients of an image's blocks, [block][v][u]. The outermost samples are repeated beyond the
/// borders.
std::vector<float> block_coefficients(const BlockGrid& grid, std::span<const float> samples);

}  // namespace multum
