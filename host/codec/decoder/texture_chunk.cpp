// SPDX-License-Identifier: Apache-2.0
#include "host/codec/decoder/texture_chunk.h"

#include <cmath>

namespace multum {
namespace {

constexpr float kGamma = 2.2f;
constexpr float kOffsetUnit = 1.0f / 64.0f;

BlockGrid grid_of(const TextureChunkFormat& format) { return {format.width, format.height, format.side}; }

}  // namespace

float radiance_of(float value) { return std::pow(std::max(value, 0.0f) / 255.0f, kGamma); }

float gamma_coded(float radiance) { return 255.0f * std::pow(std::max(radiance, 0.0f), 1.0f / kGamma); }

std::unique_ptr<TextureChunk> TextureChunk::decode(std::span<const std::uint8_t> bytes, std::string& problem) {
  ByteReader reader(bytes);
  auto format = read_chunk_format(reader, problem);
  if (!format) return nullptr;
  auto plan = format->plan();
  std::unique_ptr<TextureChunk> chunk(new TextureChunk(std::move(*format), std::move(*plan)));
  const TextureChunkFormat& f = chunk->format_;
  const ImagePlan& images = chunk->plan_;
  const auto coded = reader.bytes(reader.left());
  if (f.coder == ImageCoder::kDct) {
    DctStreamDecoder decoder(grid_of(f), coded);
    for (std::size_t i = 0; i < images.image_count() && !decoder.exhausted(); ++i) {
      const auto parent = images.parents[i];
      chunk->dct_images_.push_back(
          decoder.next_image(parent ? &chunk->dct_images_[*parent] : nullptr, images.levels[i]));
    }
    chunk->was_cut_short_ = decoder.exhausted();
    chunk->dct_images_.resize(images.image_count());
  } else {
    WaveletStreamDecoder decoder(f.width, f.height, coded);
    for (std::size_t i = 0; i < images.image_count() && !decoder.exhausted(); ++i) {
      const auto parent = images.parents[i];
      chunk->wavelet_images_.push_back(decoder.next_image(parent ? &chunk->wavelet_images_[*parent] : nullptr));
    }
    chunk->was_cut_short_ = decoder.exhausted();
    chunk->wavelet_images_.resize(images.image_count());
  }
  return chunk;
}

std::vector<float> TextureChunk::texture(std::size_t sample) const {
  const std::size_t texels = format_.width * format_.height;
  const auto rows = format_.rotation_rows();
  const std::vector<float> steps = format_.steps();
  std::vector<float> colours(3 * texels), samples(texels);
  for (std::size_t p = 0; p < 3; ++p) {
    std::fill(samples.begin(), samples.end(), kOffsetUnit * static_cast<float>(format_.offsets[p]));
    for (const auto& term : plan_.of_samples[sample]) {
      const float scale = term.weight * format_.level_scale(plan_.levels[term.image]);
      if (format_.coder == ImageCoder::kDct)
        add_samples(dct_images_[term.image], grid_of(format_), p, steps, scale, samples);
      else add_samples(wavelet_images_[term.image][p], steps, scale, samples);
    }
    for (std::size_t i = 0; i < texels; ++i)
      for (std::size_t c = 0; c < 3; ++c) colours[3 * i + c] += rows[p][c] * samples[i];
  }
  return colours;
}

}  // namespace multum
