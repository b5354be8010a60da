// SPDX-License-Identifier: Apache-2.0
// Decodes the parts of a chunk that playback needs, as 16-bit floats for upload. A part is a single image, the sum of a
// sample's images, or a whole texture. Also computes the memory of each part before it is decoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/fields/codec/decoder/texture_chunk.h"

namespace multum {

/// The parts of a chunk that are decoded and kept.
enum class DecodedKind {
  kImages,  // single images; a sample is a sum of images, which neighbouring samples share
  /// Single images as for kImages. But if two or more images of a sample are missing now, their sum is decoded in one
  /// step, which takes as long as one image. Textures are then complete sooner after a jump, but the images of a frame,
  /// and their rounding, depend on timing.
  kImagesAndSums,
  kTextures,  // whole textures of single samples, for points that are exactly on a sample: radiance with all mip levels
};

/// RGBA as 16-bit floats with an alpha of 0. This is either an image, [height][width][4], in the units of
/// TextureChunk::image, or the radiance of all mip levels, [texel][4], the finest first.
struct DecodedImage {
  std::size_t width = 0, height = 0;  // size of the finest level
  std::vector<std::uint16_t> halves;
};

/// If `number` is below the chunk's image count, it stands for an image. Higher numbers stand for samples, whose sum or
/// texture is decoded.
DecodedImage decoded_image(const TextureChunk& chunk, std::size_t number, DecodedKind kind);

/// Returns the size of a decoded image, and the memory needed while decoding it, in bytes.
std::size_t image_bytes(const TextureChunkFormat& format, DecodedKind kind);
std::size_t image_work_bytes(const TextureChunkFormat& format, DecodedKind kind);

/// Returns the most bytes that a chunk's head and plan can take.
std::size_t plan_bytes_max(const TextureChunkFormat& format);

/// Returns the bytes that a chunk's coefficients usually take.
std::size_t likely_coefficient_bytes(const TextureChunkFormat& format, std::size_t image_count,
                                     std::size_t coded_bytes);

}  // namespace multum
