// SPDX-License-Identifier: Apache-2.0
// Decodes a texture chunk. It first decodes the coefficients of all images, and then computes single images, or the
// textures of single samples, on request. Uses only C++20 and its standard library, and accesses no files. For any
// input, it throws only std::bad_alloc.
#pragma once

#include <memory>

#include "host/fields/codec/decoder/dct_stream_decoder.h"
#include "host/fields/codec/decoder/radiance.h"
#include "host/fields/codec/decoder/texture_chunk_format.h"
#include "host/fields/codec/decoder/wavelet_stream_decoder.h"

namespace multum {

class TextureChunk {
 public:
  /// If the head is invalid, returns null and sets `problem`. If the chunk is cut short after its head, decodes the
  /// available part.
  static std::unique_ptr<TextureChunk> decode(std::span<const std::uint8_t> bytes, std::string& problem) {
    return decode(bytes, problem, {});
  }
  /// Also returns null if limits are exceeded or the decoding is cancelled.
  static std::unique_ptr<TextureChunk> decode(std::span<const std::uint8_t> bytes, std::string& problem,
                                              const DecodingLimits& limits);

  const TextureChunkFormat& format() const { return format_; }
  std::size_t sample_count() const { return plan_.of_samples.size(); }

  /// Returns the texture of a sample, [height][width][3]. Red, green and blue are gamma-coded, and 255 is a radiance of
  /// 1. The values include the coding error and are not clamped.
  std::vector<float> texture(std::size_t sample) const;

  /// Returns which images add up to each sample. Up to rounding, texture(sample) is the format's offset_colour() plus
  /// the sum, over the sample's terms, of weight times image().
  const ImagePlan& plan() const { return plan_; }
  /// Returns an image, [height][width][3], in the units of texture(), without its weight and offset. The call takes no
  /// time if is_zero(). Otherwise it always computes three inverse transforms and a colour rotation, whatever the
  /// values are.
  std::vector<float> image(std::size_t number) const;
  bool is_zero(std::size_t number) const;
  /// Returns the weighted sum of a sample's images, which is the texture without the offset. Computing it takes as long
  /// as computing one image.
  std::vector<float> image_sum(std::size_t sample) const;
  /// Returns the number of bytes that the coefficients take.
  std::size_t memory_bytes() const;

  /// Returns whether the bytes ended before all images were decoded.
  bool was_cut_short() const { return was_cut_short_; }

 private:
  TextureChunk(TextureChunkFormat format, ImagePlan plan) : format_(std::move(format)), plan_(std::move(plan)) {}

  using SparseImage = std::array<SparseWaveletPlane, 3>;

  bool decode_cosines(std::span<const std::uint8_t> coded, DecodingAccount& account);
  bool decode_wavelets(std::span<const std::uint8_t> coded, DecodingAccount& account);
  /// Adds the weighted sum of these images to `colours`.
  void add_colours(std::span<const ParameterPyramid::Term> terms, std::span<float> colours) const;

  TextureChunkFormat format_;
  ImagePlan plan_;
  std::vector<CoefficientBlocks> dct_images_;  // the images are in one of these two members
  std::vector<SparseImage> wavelet_images_;
  bool was_cut_short_ = false;
};

/// Inverts radiance_of(). Returns 0 for negative radiance.
float gamma_coded(float radiance);

}  // namespace multum
