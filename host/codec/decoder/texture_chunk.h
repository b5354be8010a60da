// SPDX-License-Identifier: Apache-2.0
// Decodes a texture chunk: first the coefficients of all its images, then, as they are asked for, the textures of
// single samples. C++20 and its library alone; no file is touched, and no bytes make it throw but std::bad_alloc.
#pragma once

#include <memory>

#include "host/codec/decoder/dct_stream_decoder.h"
#include "host/codec/decoder/texture_chunk_format.h"
#include "host/codec/decoder/wavelet_stream_decoder.h"

namespace multum {

class TextureChunk {
 public:
  /// Nothing where the head is wrong: `problem` then says how. Of a chunk cut short behind its head, what is there
  /// counts.
  static std::unique_ptr<TextureChunk> decode(std::span<const std::uint8_t> bytes, std::string& problem);

  const TextureChunkFormat& format() const { return format_; }
  std::size_t sample_count() const { return plan_.of_samples.size(); }

  /// The texture of a sample, [height][width][3]: red, green, blue as gamma-coded values, 255 for a radiance of 1, with
  /// whatever error the coder left; not clamped.
  std::vector<float> texture(std::size_t sample) const;

  /// The bytes ended before the images did.
  bool was_cut_short() const { return was_cut_short_; }

 private:
  TextureChunk(TextureChunkFormat format, ImagePlan plan) : format_(std::move(format)), plan_(std::move(plan)) {}

  TextureChunkFormat format_;
  ImagePlan plan_;
  std::vector<CoefficientBlocks> dct_images_;  // one of these two has the images
  std::vector<WaveletImage> wavelet_images_;
  bool was_cut_short_ = false;
};

/// Radiance of a gamma-coded value: (value / 255)^2.2, 0 below 0.
float radiance_of(float value);
/// The reverse; 0 below 0.
float gamma_coded(float radiance);

}  // namespace multum
