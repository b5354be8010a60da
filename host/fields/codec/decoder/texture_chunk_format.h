// SPDX-License-Identifier: Apache-2.0
// Reads the head of a texture chunk. A chunk contains the textures of one layer of an object over one block of
// parameters. The head lists the images, their coder and their quantization steps. Numbers are written as in
// ByteReader. After the head, the stream of the image coder extends to the chunk's end.
//
//      flags                 1 byte: 1 wavelets, 2 linear over parameters, 4 basis; 2 and 4 not together
//      width, height         numbers, texels, 1 to 16384
//      dimensions, levels    1 byte each, 1 to 8 and 1 to 32; with a basis, its images, 1 to 64
//      sizes                 numbers: samples along each dimension
//      per level             halvings, 1 byte per dimension; of a basis weights, 1 signed byte per sample; level code
//      side                  1 byte: 8, 16 or 32; only for cosines
//      rotation              4 times 2 bytes
//      offsets               3 times 2 bytes
//      step codes            1 byte each, step_code_count()
#pragma once

#include <array>
#include <optional>
#include <string>

#include "host/fields/codec/decoder/byte_reader.h"
#include "host/fields/codec/decoder/parameter_pyramid.h"

namespace multum {

enum class ImageCoder : std::uint8_t { kDct = 0, kWavelet = 1 };

/// The images, and which of them add up to each sample.
struct ImagePlan {
  std::vector<std::size_t> levels;                              // level of each image
  std::vector<std::optional<std::size_t>> parents;              // the earlier image that each image refines
  std::vector<std::vector<ParameterPyramid::Term>> of_samples;  // terms of each sample

  std::size_t image_count() const { return levels.size(); }
};

struct TextureChunkFormat {
  static constexpr std::size_t kSideMax = 16384;
  /// The maximum number of texels in all images together. This limit bounds a decoder's time and memory.
  static constexpr std::size_t kTexelsMax = std::size_t{1} << 28;
  /// The maximum number of terms in the sums of all samples together.
  static constexpr std::size_t kTermsMax = std::size_t{1} << 22;
  static constexpr std::size_t kBasisMax = 64;  // images of a basis

  ImageCoder coder = ImageCoder::kDct;
  std::size_t width = 1, height = 1;  // texels, up to kSideMax
  std::vector<std::size_t> sizes;     // samples along each dimension of the block
  std::vector<ParameterPyramid::Halvings> levels;
  /// The weights of a basis, which replaces the pyramid. They are the weight of each image in each sample, in units of
  /// 1/127, [image][sample]. A basis has only one level.
  std::vector<std::vector<std::int8_t>> basis;
  bool linear = false;     // interpolate images over parameters instead of using the nearest one
  std::uint8_t side = 16;  // side of cosine blocks
  /// A rotation of colours as a quaternion (w, x, y, z in units of 1/32767), and the offset of each rotated plane in
  /// units of 1/64.
  std::array<std::int16_t, 4> rotation{32767, 0, 0, 0};
  std::array<std::int16_t, 3> offsets{};
  /// The codes of the quantization steps, which are 2^(code / 8). Cosines have one code per bit_width of the index
  /// along rows, then one code per bit_width of the index along columns. Wavelets have one code per band.
  std::vector<std::uint8_t> step_codes;
  /// There is one code per level. All steps of the level are multiplied by 2^(code / 8 - 8).
  std::vector<std::uint8_t> level_codes;

  /// Returns the size that step_codes must have.
  std::size_t step_code_count() const;
  /// Returns the steps of all places in a cosine block, [v][u], or of all wavelet bands.
  std::vector<float> steps() const;
  float level_scale(std::size_t level) const;
  /// Returns the weights of red, green and blue in plane p as row p. The rows are orthonormal. Colour c is the sum of
  /// the planes, each multiplied by its element of column c.
  std::array<std::array<float, 3>, 3> rotation_rows() const;
  /// Returns the colour (red, green and blue) that is added to every sum of images.
  std::array<float, 3> offset_colour() const;
  /// Returns nullopt if the levels do not form a pyramid over the block.
  std::optional<ImagePlan> plan() const;
};

/// Reads a head. If it is invalid, returns nullopt and sets `problem`.
std::optional<TextureChunkFormat> read_chunk_format(ByteReader& reader, std::string& problem);

}  // namespace multum
