// SPDX-License-Identifier: Apache-2.0
// Decodes the images of a pyramid over parameters from one stream of wavelet coefficients (wavelet_syntax.h), and
// computes their samples. If the stream is cut short, it uses every bit that is certain.
#pragma once

#include "host/fields/codec/decoder/decoding_limits.h"
#include "host/fields/codec/decoder/wavelet_syntax.h"

namespace multum {

/// The three planes of an image. Planes without coefficients are empty.
using WaveletImage = std::array<WaveletPlane, 3>;

class WaveletStreamDecoder {
 public:
  /// The bytes and the limits must outlive the decoder.
  WaveletStreamDecoder(std::size_t width, std::size_t height, std::span<const std::uint8_t> bytes,
                       DecodingAccount* account = nullptr)
      : width_(width), height_(height), port_(bytes), coder_(port_), account_(account) {}
  WaveletStreamDecoder(const WaveletStreamDecoder&) = delete;
  WaveletStreamDecoder& operator=(const WaveletStreamDecoder&) = delete;

  /// Decodes the stream's next image. `parent` is an earlier image that this image refines, or null.
  WaveletImage next_image(const WaveletImage* parent);

  /// Returns whether the stream ended before all its images were decoded.
  bool exhausted() const { return port_.exhausted(); }

 private:
  std::size_t width_, height_;
  WaveletSyntax syntax_;
  DecodingPort port_;
  SymbolCoder<DecodingPort> coder_;
  DecodingAccount* account_;
};

/// The nonzero coefficients of a plane. Once all images predicted from the plane are decoded, only these coefficients
/// are needed to compute its samples.
class SparseWaveletPlane {
 public:
  SparseWaveletPlane() = default;
  explicit SparseWaveletPlane(const WaveletPlane& plane);

  bool is_empty() const { return coefficients_.empty(); }
  std::size_t memory_bytes() const { return coefficients_.capacity() * sizeof(Coefficient); }
  /// Adds the plane's coefficients, [height][width], as dequantized() computes them.
  void add_coefficients(std::span<const float> steps, float scale, std::span<float> coefficients) const;

 private:
  struct Coefficient {
    std::uint32_t at, band;
    float value;  // value in steps
  };
  std::vector<Coefficient> coefficients_;
};

/// Returns the memory that an image takes while it is decoded.
std::size_t dense_bytes(const WaveletImage& image);

/// Returns the plane's coefficients, [height][width], or nothing for an empty plane. `steps` has one step per band, in
/// the order of wavelet_bands. All steps are multiplied by `scale`.
std::vector<float> dequantized(const WaveletPlane& plane, std::span<const float> steps, float scale);

/// Adds the plane's samples to `samples`, width * height values.
void add_samples(const WaveletPlane& plane, std::span<const float> steps, float scale, std::span<float> samples);

}  // namespace multum
