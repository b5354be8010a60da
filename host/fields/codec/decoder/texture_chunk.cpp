// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/texture_chunk.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace multum {
namespace {

constexpr float kGamma = 2.2f;

BlockGrid grid_of(const TextureChunkFormat& format) { return {format.width, format.height, format.side}; }

}  // namespace

float gamma_coded(float radiance) { return 255.0f * std::pow(std::max(radiance, 0.0f), 1.0f / kGamma); }

bool TextureChunk::decode_cosines(std::span<const std::uint8_t> coded, DecodingAccount& account) {
  DctStreamDecoder decoder(grid_of(format_), coded, &account);
  std::size_t kept = 0;
  for (std::size_t i = 0; i < plan_.image_count() && !decoder.exhausted(); ++i) {
    const auto parent = plan_.parents[i];
    const CoefficientBlocks* before = i > 0 ? &dct_images_[i - 1] : nullptr;
    dct_images_.push_back(decoder.next_image(parent ? &dct_images_[*parent] : nullptr, before, plan_.levels[i]));
    dct_images_.back().shrink();
    account.set_kept(kept += dct_images_.back().memory_bytes());
    if (account.is_over(0)) return false;
  }
  was_cut_short_ = decoder.exhausted();
  dct_images_.resize(plan_.image_count());
  return true;
}

bool TextureChunk::decode_wavelets(std::span<const std::uint8_t> coded, DecodingAccount& account) {
  WaveletStreamDecoder decoder(format_.width, format_.height, coded, &account);
  std::vector<std::size_t> last_child(plan_.image_count());
  for (std::size_t i = 0; i < plan_.image_count(); ++i)
    if (const auto parent = plan_.parents[i]) last_child[*parent] = i;
  std::map<std::size_t, WaveletImage> dense;  // images from which later images are still predicted
  std::size_t kept = 0;
  for (std::size_t i = 0; i < plan_.image_count() && !decoder.exhausted(); ++i) {
    const auto parent = plan_.parents[i];
    WaveletImage image = decoder.next_image(parent ? &dense[*parent] : nullptr);
    wavelet_images_.emplace_back();
    for (std::size_t p = 0; p < image.size(); ++p) {
      wavelet_images_.back()[p] = SparseWaveletPlane(image[p]);
      kept += wavelet_images_.back()[p].memory_bytes();
    }
    if (last_child[i] > i) dense.emplace(i, std::move(image));
    std::erase_if(dense, [&](const auto& entry) { return last_child[entry.first] <= i; });
    std::size_t needed = kept;
    for (const auto& [number, planes] : dense) needed += dense_bytes(planes);
    account.set_kept(needed);
    if (account.is_over(0)) return false;
  }
  was_cut_short_ = decoder.exhausted();
  wavelet_images_.resize(plan_.image_count());
  return true;
}

std::unique_ptr<TextureChunk> TextureChunk::decode(std::span<const std::uint8_t> bytes, std::string& problem,
                                                   const DecodingLimits& limits) {
  ByteReader reader(bytes);
  auto format = read_chunk_format(reader, problem);
  if (!format) return nullptr;
  auto plan = format->plan();
  std::unique_ptr<TextureChunk> chunk(new TextureChunk(std::move(*format), std::move(*plan)));
  const auto coded = reader.bytes(reader.left());
  DecodingAccount account(limits);
  const bool is_whole = chunk->format_.coder == ImageCoder::kDct ? chunk->decode_cosines(coded, account)
                                                                 : chunk->decode_wavelets(coded, account);
  if (is_whole) return chunk;
  problem = account.has_no_room() ? "its coefficients take more than " + std::to_string(limits.bytes_max) + " bytes"
                                  : "its decoding was cancelled";
  return nullptr;
}

void TextureChunk::add_colours(std::span<const ParameterPyramid::Term> terms, std::span<float> colours) const {
  const auto rows = format_.rotation_rows();
  const std::vector<float> steps = format_.steps();
  const auto scale_of = [&](const auto& term) { return term.weight * format_.level_scale(plan_.levels[term.image]); };
  // The coefficients are summed instead of the images, so that only one transform is needed.
  if (format_.coder == ImageCoder::kDct) {
    std::vector<WeighedImage> images;
    for (const auto& term : terms)
      if (!dct_images_[term.image].is_empty()) images.push_back({&dct_images_[term.image], scale_of(term)});
    multum::add_colours(images, grid_of(format_), steps, rows, colours);
    return;
  }
  std::vector<float> samples(format_.width * format_.height);
  for (std::size_t p = 0; p < 3; ++p) {
    bool is_zero = true;
    for (const auto& term : terms) {
      const SparseWaveletPlane& coefficients = wavelet_images_[term.image][p];
      is_zero = is_zero && coefficients.is_empty();
      coefficients.add_coefficients(steps, scale_of(term), samples);
    }
    if (is_zero) continue;
    inverse_wavelet(format_.width, format_.height, samples);
    for (std::size_t i = 0; i < samples.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c) colours[3 * i + c] += rows[p][c] * samples[i];
    std::fill(samples.begin(), samples.end(), 0.0f);
  }
}

std::vector<float> TextureChunk::texture(std::size_t sample) const {
  const auto offset = format_.offset_colour();
  std::vector<float> colours(3 * format_.width * format_.height);
  for (std::size_t i = 0; i < colours.size(); i += 3)
    std::copy(offset.begin(), offset.end(), colours.begin() + static_cast<std::ptrdiff_t>(i));
  add_colours(plan_.of_samples[sample], colours);
  return colours;
}

std::vector<float> TextureChunk::image_sum(std::size_t sample) const {
  std::vector<float> colours(3 * format_.width * format_.height);
  add_colours(plan_.of_samples[sample], colours);
  return colours;
}

bool TextureChunk::is_zero(std::size_t number) const {
  if (format_.coder == ImageCoder::kDct) return dct_images_[number].is_empty();
  return std::all_of(wavelet_images_[number].begin(), wavelet_images_[number].end(),
                     [](const SparseWaveletPlane& plane) { return plane.is_empty(); });
}

std::vector<float> TextureChunk::image(std::size_t number) const {
  std::vector<float> colours(3 * format_.width * format_.height);
  const ParameterPyramid::Term term{number, 1.0f};
  if (!is_zero(number)) add_colours({&term, 1}, colours);
  return colours;
}

std::size_t TextureChunk::memory_bytes() const {
  std::size_t bytes = 0;
  for (const CoefficientBlocks& image : dct_images_) bytes += image.memory_bytes();
  for (const SparseImage& image : wavelet_images_)
    for (const SparseWaveletPlane& plane : image) bytes += plane.memory_bytes();
  return bytes;
}

}  // namespace multum
