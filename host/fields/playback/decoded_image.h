// SPDX-License-Identifier: Apache-2.0
// Decodes what a field that is played needs of a chunk: an image that samples are sums of, the sum of a sample's, or a
// whole texture, as halves to be uploaded; and the memory that each takes, known before it is decoded.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/fields/codec/decoder/texture_chunk.h"

namespace multum {

/// What is decoded of a chunk and kept.
enum class DecodedKind {
  kImages,  // of which samples are the sum, shared by neighbouring samples
  /// The same, and the sum of a sample's images at once, for the price of one, where two or more are missing now: after
  /// a jump textures are whole sooner. Which images a frame is made of then depends on time, and so does their
  /// rounding.
  kImagesAndSums,
  kTextures,  // of single samples, whole: radiance with all mip levels. For points without shares of several samples
};

/// RGBA halves, [height][width][4], in the units of TextureChunk::image; or radiance, [texel][4] of all mip levels, the
/// finest first. Alpha 0.
struct DecodedImage {
  std::size_t width = 0, height = 0;  // of the finest level
  std::vector<std::uint16_t> halves;
};

/// `number`: of an image; from the chunk's image count on, of a sample, its sum or texture.
DecodedImage decoded_image(const TextureChunk& chunk, std::size_t number, DecodedKind kind);

/// Bytes of a decoded image, and of what decoding it takes besides.
std::size_t image_bytes(const TextureChunkFormat& format, DecodedKind kind);
std::size_t image_work_bytes(const TextureChunkFormat& format, DecodedKind kind);

/// Bytes of a head and its plan, at most.
std::size_t plan_bytes_max(const TextureChunkFormat& format);

/// Bytes that a chunk's coefficients take as a rule.
std::size_t likely_coefficient_bytes(const TextureChunkFormat& format, std::size_t image_count,
                                     std::size_t coded_bytes);

}  // namespace multum
