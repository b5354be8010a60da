// SPDX-License-Identifier: Apache-2.0
// Encodes the images of a pyramid over parameters into the stream that DctStreamDecoder reads. Coefficients are chosen
// by rate and distortion: a block is tried with fewer bands, and each of its coefficients one nearer to zero, at what
// the contexts then say the symbols take, and what makes error + lambda bits least is kept.
#pragma once

#include "host/fields/codec/coding_ports.h"
#include "host/fields/codec/decoder/dct_stream_decoder.h"

namespace multum {

/// What of an image shall be coded, and how well.
struct DctTarget {
  /// Of each plane, block by block: the coefficients wanted; grid.count() * side * side.
  std::array<std::vector<float>, CoefficientBlocks::kPlanes> coefficients;
  /// Of one block after another: what the square of a coefficient's error weighs, at least 0; 0 where nothing sees it.
  std::vector<float> weights;
  std::vector<float> steps;  // above 0, of each place of a block
  float scale = 1.0f;        // of all steps
  float lambda = 0.0f;       // weighed squared error that one bit is worth
};

class DctStreamEncoder {
 public:
  explicit DctStreamEncoder(const BlockGrid& grid)
      : grid_(grid), groups_(grid), syntax_(static_cast<int>(grid.side)), coder_(port_) {}
  DctStreamEncoder(const DctStreamEncoder&) = delete;
  DctStreamEncoder& operator=(const DctStreamEncoder&) = delete;

  /// Codes the next image; what the decoder will have is returned. `parent`, `before` and `level` as in the decoder.
  CoefficientBlocks add_image(const DctTarget& target, const CoefficientBlocks* parent, const CoefficientBlocks* before,
                              std::size_t level);

  std::size_t bits() const { return port_.bits(); }
  /// Ends the stream; nothing may be added afterwards.
  std::vector<std::uint8_t> finish() { return port_.finish(); }

 private:
  using Values = std::vector<std::int16_t>;

  /// Where an image stands among others.
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

/// Cosine coefficients of an image's blocks, [block][v][u]; beyond the borders the outermost samples go on.
std::vector<float> block_coefficients(const BlockGrid& grid, std::span<const float> samples);

}  // namespace multum
