// SPDX-License-Identifier: Apache-2.0
// Encodes the images of a pyramid over parameters into the stream that WaveletStreamDecoder reads. Any prefix can be
// decoded. It contains all images before the cut completely, and the last image down to its last complete bit plane.
#pragma once

#include "host/fields/codec/coding_ports.h"
#include "host/fields/codec/decoder/wavelet_stream_decoder.h"

namespace multum {

/// The target coefficients of an image, and their required precision.
struct WaveletTarget {
  std::array<std::vector<float>, 3> coefficients;  // planes, [height][width] as forward_wavelet computes them
  /// The weight of each coefficient's squared error, [height][width]. Weights are at least 0, and 0 for invisible
  /// coefficients.
  std::vector<float> weights;
  std::vector<float> steps;  // steps above 0, one per band in the order of wavelet_bands
  float scale = 1.0f;        // multiplies all steps
  float lambda = 0.0f;       // the weighted squared error that justifies one bit
};

class WaveletStreamEncoder {
 public:
  WaveletStreamEncoder(std::size_t width, std::size_t height) : width_(width), height_(height), coder_(port_) {}
  WaveletStreamEncoder(const WaveletStreamEncoder&) = delete;
  WaveletStreamEncoder& operator=(const WaveletStreamEncoder&) = delete;

  /// Codes the next image and returns the image that the decoder will have. `parent` is as in the decoder.
  WaveletImage add_image(const WaveletTarget& target, const WaveletImage* parent);

  std::size_t bits() const { return port_.bits(); }
  /// Ends the stream. Nothing may be added afterwards.
  std::vector<std::uint8_t> finish() { return port_.finish(); }

 private:
  std::size_t width_, height_;
  WaveletSyntax syntax_;
  EncodingPort port_;
  SymbolCoder<EncodingPort> coder_;
};

}  // namespace multum
