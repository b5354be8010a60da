// SPDX-License-Identifier: Apache-2.0
#include "host/fields/playback/decoded_image.h"

#include <algorithm>
#include <array>
#include <span>

#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/field_unpacking.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/vector_clones.h"

namespace multum {
namespace {

constexpr std::size_t kHalfBytes = 8;  // bytes per texel of an image: four 16-bit floats, RGBA
// The bytes per texel while an image is decoded, for three colours, a plane, and lines of wavelets.
constexpr std::size_t kWorkBytes = 20;
constexpr std::size_t kTextureWorkBytes = 32;  // bytes per texel of a texture: three colours of the finest level, and
                                               // three of all mip levels

std::size_t texels_of(const TextureChunkFormat& format) { return format.width * format.height; }

MULTUM_VECTOR_CLONES void round_to_halves(const float* values, std::size_t count, std::uint16_t* halves) {
  for (std::size_t i = 0; i < count; ++i) halves[i] = clamped_to_half(values[i]);
}

/// Writes three floats per texel as the first three of four 16-bit floats, and does not change the fourth. Rounds some
/// hundred texels at a time, without the fourth value, so that the compiler can vectorize the loop.
void write_halves(std::span<const float> colours, std::span<std::uint16_t> halves) {
  constexpr std::size_t kTexels = 256;
  std::array<std::uint16_t, 3 * kTexels> rounded;
  const std::size_t texels = colours.size() / 3;
  for (std::size_t first = 0; first < texels; first += kTexels) {
    const std::size_t count = std::min(kTexels, texels - first);
    round_to_halves(colours.data() + 3 * first, 3 * count, rounded.data());
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t c = 0; c < 3; ++c) halves[4 * (first + i) + c] = rounded[3 * i + c];
  }
}

}  // namespace

DecodedImage decoded_image(const TextureChunk& chunk, std::size_t number, DecodedKind kind) {
  const TextureChunkFormat& format = chunk.format();
  const std::size_t images = chunk.plan().image_count();
  const std::vector<float> colours = number < images                  ? chunk.image(number)
                                     : kind == DecodedKind::kTextures ? radiance_levels(chunk, number - images)
                                                                      : chunk.image_sum(number - images);
  DecodedImage result{format.width, format.height, std::vector<std::uint16_t>(colours.size() / 3 * 4)};
  write_halves(colours, result.halves);
  return result;
}

std::size_t image_bytes(const TextureChunkFormat& format, DecodedKind kind) {
  return kHalfBytes *
         (kind == DecodedKind::kTextures ? mip_texel_count(format.width, format.height) : texels_of(format));
}

std::size_t image_work_bytes(const TextureChunkFormat& format, DecodedKind kind) {
  return (kind == DecodedKind::kTextures ? kTextureWorkBytes : kWorkBytes) * texels_of(format);
}

/// A plan needs 24 bytes per vector, 16 per term and 64 per image. read_chunk_format() limits S L 2^D to 2^22, so no
/// product overflows.
std::size_t plan_bytes_max(const TextureChunkFormat& format) {
  std::size_t samples = 1;
  for (const std::size_t size : format.sizes) samples *= size;
  const std::size_t levels = std::max(format.levels.size(), format.basis.size());
  const std::size_t terms = samples * levels << (format.linear ? format.sizes.size() : 0);
  return 24 * samples + 16 * terms + 64 * samples * levels + samples * format.basis.size();
}

/// Cosines need one place for each block of each plane, plus this many bytes per coded byte. (In files of field_demo1
/// at ratios of 60:1 to 800:1, they need at most 250 bytes per coded byte.) Wavelets need two images at a time, with
/// eight bytes per texel of each plane.
std::size_t likely_coefficient_bytes(const TextureChunkFormat& format, std::size_t image_count,
                                     std::size_t coded_bytes) {
  const std::size_t blocks = (format.width / format.side + 1) * (format.height / format.side + 1);
  return 256 * coded_bytes +
         (format.coder == ImageCoder::kWavelet ? 48 * texels_of(format) : 12 * image_count * blocks);
}

}  // namespace multum
