// SPDX-License-Identifier: Apache-2.0
// Reads the head of a texture chunk: the textures of one layer of an object over one block of parameters. It says which
// images there are, how they are coded and how coarsely. Numbers are ByteReader's; what follows the head to the chunk's
// end is the stream of the image coder.
//
//      flags                 1 byte: 1 wavelets, 2 linear over parameters, 4 basis; 2 and 4 not together
//      width, height         numbers, texels, 1 to 16384
//      dimensions, levels    1 byte each, 1 to 8 and 1 to 32; with a basis, its images, 1 to 64
//      sizes                 numbers: samples along each dimension
//      of each level         halvings, 1 byte a dimension; of a basis weights, 1 signed byte a sample; then level code
//      side                  1 byte: 8, 16 or 32; cosines alone
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

/// Which images add up to which samples.
struct ImagePlan {
  std::vector<std::size_t> levels;                              // of each image
  std::vector<std::optional<std::size_t>> parents;              // that an image refines, coded before it
  std::vector<std::vector<ParameterPyramid::Term>> of_samples;  // of each sample

  std::size_t image_count() const { return levels.size(); }
};

struct TextureChunkFormat {
  static constexpr std::size_t kSideMax = 16384;
  /// Texels of all images together; what a chunk may ask of a decoder's time and memory is bounded by it.
  static constexpr std::size_t kTexelsMax = std::size_t{1} << 28;
  /// Images that samples are sums of, over all samples.
  static constexpr std::size_t kTermsMax = std::size_t{1} << 22;
  static constexpr std::size_t kBasisMax = 64;  // images of a basis

  ImageCoder coder = ImageCoder::kDct;
  std::size_t width = 1, height = 1;  // texels, up to kSideMax
  std::vector<std::size_t> sizes;     // samples along each dimension of the block
  std::vector<ParameterPyramid::Halvings> levels;
  /// In place of a pyramid: what each of a few images weighs in each sample, in 1/127, [image][sample]. A level has
  /// one.
  std::vector<std::vector<std::int8_t>> basis;
  bool linear = false;     // images are interpolated over parameters, not taken from the nearest
  std::uint8_t side = 16;  // of cosine blocks
  /// A rotation of colours as a quaternion w, x, y, z in 1/32767, and the offset of each rotated plane in 1/64.
  std::array<std::int16_t, 4> rotation{32767, 0, 0, 0};
  std::array<std::int16_t, 3> offsets{};
  /// Quantization steps 2^(code / 8): cosines by bit_width of the index along rows, then columns; wavelets by band.
  std::vector<std::uint8_t> step_codes;
  /// Factors of all steps of a level, 2^(code / 8 - 8).
  std::vector<std::uint8_t> level_codes;

  /// Numbers that step_codes must have.
  std::size_t step_code_count() const;
  /// Steps of the places of a cosine block, [v][u], or of the bands.
  std::vector<float> steps() const;
  float level_scale(std::size_t level) const;
  /// Row p: what red, green and blue weigh in plane p. Orthonormal; colour c is the sum of column c times the planes.
  std::array<std::array<float, 3>, 3> rotation_rows() const;
  /// What is added to every sum of images, red, green, blue.
  std::array<float, 3> offset_colour() const;
  /// Nothing where the levels are no pyramid over the block.
  std::optional<ImagePlan> plan() const;
};

/// Reads a head. Nothing where it is wrong: `problem` then says how.
std::optional<TextureChunkFormat> read_chunk_format(ByteReader& reader, std::string& problem);

}  // namespace multum
