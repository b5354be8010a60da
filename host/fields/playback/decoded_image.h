// SPDX-License-Identifier: Apache-2.0
// Decodes the parts of a chunk that playback needs, as half floats for upload: a single image, the sum of a sample's
// images, or a whole texture. Also computes the memory of each part before it is decoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/fields/codec/decoder/texture_chunk.h"

namespace multum {

/// The parts of a chunk that are decoded and kept.
enum class DecodedKind {
  kImages,  // single images; a sample is a sum of images, which neighbouring samples share
  /// Like kImages, but decodes the sum of a sample's images in one step, at the cost of one image, if two or more
  /// images are missing now. Textures are then complete sooner after a jump, but the images of a frame, and their
  /// rounding, depend on time.
  kImagesAndSums,
  kTextures,  // whole textures of single samples: radiance with all mip levels. For points on a single sample
};

/// RGBA halves, [height][width][4], in the units of TextureChunk::image; or radiance, [texel][4] of all mip levels, the
/// finest first. Alpha is 0.
struct DecodedImage {
  std::size_t width = 0, height = 0;  // size of the finest level
  std::vector<std::uint16_t> halves;
};

/// `number`: an image; from the chunk's image count on, a sample, whose sum or texture is decoded.
DecodedImage decoded_image(const TextureChunk& chunk, std::size_t number, DecodedKind kind);

/// Returns the bytes of a decoded image, and the bytes needed while decoding it.
std::size_t image_bytes(const TextureChunkFormat& format, DecodedKind kind);
std::size_t image_work_bytes(const TextureChunkFormat& format, DecodedKind kind);

/// Returns the most bytes that a head and its plan take.
std::size_t plan_bytes_max(const TextureChunkFormat& format);

/// Returns the bytes that a chunk's coefficients usually take.
std::size_t likely_coefficient_bytes(const TextureChunkFormat& format, std::size_t image_count,
                                     std::size_t coded_bytes);

}  // namespace multum
