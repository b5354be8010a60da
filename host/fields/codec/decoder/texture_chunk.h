// SPDX-License-Identifier: Apache-2.0
// Decodes a texture chunk: first the coefficients of all its images, then, as they are asked for, single images or the
// textures of single samples. C++20 and its library alone; no file is touched, and no bytes make it throw but
// std::bad_alloc.
#pragma once

#include <memory>

#include "host/fields/codec/decoder/dct_stream_decoder.h"
#include "host/fields/codec/decoder/radiance.h"
#include "host/fields/codec/decoder/texture_chunk_format.h"
#include "host/fields/codec/decoder/wavelet_stream_decoder.h"

namespace multum {

class TextureChunk {
 public:
  /// Nothing where the head is wrong: `problem` then says how. Of a chunk cut short behind its head, what is there
  /// counts.
  static std::unique_ptr<TextureChunk> decode(std::span<const std::uint8_t> bytes, std::string& problem) {
    return decode(bytes, problem, {});
  }
  /// Nothing also where limits are exceeded, or it was cancelled.
  static std::unique_ptr<TextureChunk> decode(std::span<const std::uint8_t> bytes, std::string& problem,
                                              const DecodingLimits& limits);

  const TextureChunkFormat& format() const { return format_; }
  std::size_t sample_count() const { return plan_.of_samples.size(); }

  /// The texture of a sample, [height][width][3]: red, green, blue as gamma-coded values, 255 for a radiance of 1, with
  /// whatever error the coder left; not clamped.
  std::vector<float> texture(std::size_t sample) const;

  /// Which images add up to a sample. texture(sample) is the format's offset_colour() plus the sum of its terms'
  /// weights times image(), but for rounding.
  const ImagePlan& plan() const { return plan_; }
  /// [height][width][3] in the units of texture(), without weight and offset. Takes as long whatever is in it: three
  /// inverse transforms and a turn of colours, or nothing where is_zero().
  std::vector<float> image(std::size_t number) const;
  bool is_zero(std::size_t number) const;
  /// The sum of a sample's images, weighed: the texture without the offset, for the price of one image.
  std::vector<float> image_sum(std::size_t sample) const;
  /// Bytes of coefficients.
  std::size_t memory_bytes() const;

  /// The bytes ended before the images did.
  bool was_cut_short() const { return was_cut_short_; }

 private:
  TextureChunk(TextureChunkFormat format, ImagePlan plan) : format_(std::move(format)), plan_(std::move(plan)) {}

  using SparseImage = std::array<SparseWaveletPlane, 3>;

  bool decode_cosines(std::span<const std::uint8_t> coded, DecodingAccount& account);
  bool decode_wavelets(std::span<const std::uint8_t> coded, DecodingAccount& account);
  /// The sum of these images, weighed, added to `colours`.
  void add_colours(std::span<const ParameterPyramid::Term> terms, std::span<float> colours) const;

  TextureChunkFormat format_;
  ImagePlan plan_;
  std::vector<CoefficientBlocks> dct_images_;  // one of these two has the images
  std::vector<SparseImage> wavelet_images_;
  bool was_cut_short_ = false;
};

/// The reverse of radiance_of(); 0 below 0.
float gamma_coded(float radiance);

}  // namespace multum
