// SPDX-License-Identifier: Apache-2.0
// Encodes the images of a pyramid over parameters into the stream that WaveletStreamDecoder reads. Any prefix of it
// decodes: images before the cut wholly, the one that it falls into to the bit plane reached.
#pragma once

#include "host/fields/codec/coding_ports.h"
#include "host/fields/codec/decoder/wavelet_stream_decoder.h"

namespace multum {

/// What of an image shall be coded, and how well.
struct WaveletTarget {
  std::array<std::vector<float>, 3> coefficients;  // of each plane, [height][width] as forward_wavelet leaves them
  /// What the square of a coefficient's error weighs, at least 0, [height][width]; 0 where nothing sees it.
  std::vector<float> weights;
  std::vector<float> steps;  // above 0, of each band as wavelet_bands has them
  float scale = 1.0f;        // of all steps
  float lambda = 0.0f;       // weighed squared error that one bit is worth
};

class WaveletStreamEncoder {
 public:
  WaveletStreamEncoder(std::size_t width, std::size_t height) : width_(width), height_(height), coder_(port_) {}
  WaveletStreamEncoder(const WaveletStreamEncoder&) = delete;
  WaveletStreamEncoder& operator=(const WaveletStreamEncoder&) = delete;

  /// Codes the next image; what the decoder will have is returned. `parent` as in the decoder.
  WaveletImage add_image(const WaveletTarget& target, const WaveletImage* parent);

  std::size_t bits() const { return port_.bits(); }
  /// Ends the stream; nothing may be added afterwards.
  std::vector<std::uint8_t> finish() { return port_.finish(); }

 private:
  std::size_t width_, height_;
  WaveletSyntax syntax_;
  EncodingPort port_;
  SymbolCoder<EncodingPort> coder_;
};

}  // namespace multum
