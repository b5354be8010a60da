// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/decoder/texture_chunk_format.h"

#include <bit>
#include <cmath>

#include "host/fields/codec/decoder/block_dct.h"
#include "host/fields/codec/decoder/wavelet_transform.h"

namespace multum {
namespace {

constexpr float kOffsetUnit = 1.0f / 64.0f;

float power_of_eighths(int code) { return std::exp2(static_cast<float>(code) / 8.0f); }

std::size_t frequency_classes(std::size_t side) { return static_cast<std::size_t>(std::bit_width(side)); }

}  // namespace

std::size_t TextureChunkFormat::step_code_count() const {
  return coder == ImageCoder::kDct ? 2 * frequency_classes(side) : wavelet_bands(width, height).size();
}

std::vector<float> TextureChunkFormat::steps() const {
  std::vector<float> steps;
  if (coder == ImageCoder::kWavelet) {
    for (const std::uint8_t code : step_codes) steps.push_back(power_of_eighths(code));
    return steps;
  }
  const std::size_t classes = frequency_classes(side);
  for (std::size_t v = 0; v < side; ++v)
    for (std::size_t u = 0; u < side; ++u)
      steps.push_back(power_of_eighths(step_codes[static_cast<std::size_t>(std::bit_width(u))] +
                                       step_codes[classes + static_cast<std::size_t>(std::bit_width(v))]));
  return steps;
}

float TextureChunkFormat::level_scale(std::size_t level) const { return power_of_eighths(level_codes[level] - 64); }

std::array<std::array<float, 3>, 3> TextureChunkFormat::rotation_rows() const {
  double q[4] = {1.0, 0.0, 0.0, 0.0}, length = 0.0;
  for (std::size_t i = 0; i < 4; ++i) length += static_cast<double>(rotation[i]) * rotation[i];
  for (std::size_t i = 0; i < 4 && length > 0.0; ++i) q[i] = rotation[i] / std::sqrt(length);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double rows[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)},
                             {2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)},
                             {2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)}};
  std::array<std::array<float, 3>, 3> result{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) result[i][j] = static_cast<float>(rows[i][j]);
  return result;
}

std::array<float, 3> TextureChunkFormat::offset_colour() const {
  const auto rows = rotation_rows();
  std::array<float, 3> colour{};
  for (std::size_t p = 0; p < 3; ++p)
    for (std::size_t c = 0; c < 3; ++c) colour[c] += rows[p][c] * kOffsetUnit * static_cast<float>(offsets[p]);
  return colour;
}

std::optional<ImagePlan> TextureChunkFormat::plan() const {
  ImagePlan plan;
  if (!basis.empty()) {
    plan.of_samples.resize(basis[0].size());
    for (std::size_t i = 0; i < basis.size(); ++i) {
      plan.levels.push_back(i);
      plan.parents.push_back(i > 0 ? std::optional<std::size_t>(0) : std::nullopt);
      for (std::size_t s = 0; s < basis[i].size(); ++s)
        if (basis[i][s] != 0) plan.of_samples[s].push_back({i, static_cast<float>(basis[i][s]) / 127.0f});
    }
    return plan;
  }
  const auto pyramid = ParameterPyramid::of(sizes, levels);
  if (!pyramid) return {};
  for (std::size_t i = 0; i < pyramid->image_count(); ++i) {
    plan.levels.push_back(pyramid->level_of(i));
    plan.parents.push_back(pyramid->parent_of(i));
  }
  plan.of_samples.resize(pyramid->sample_count());
  for (std::size_t s = 0; s < plan.of_samples.size(); ++s)
    for (std::size_t l = 0; l < pyramid->level_count(); ++l)
      for (const auto& term : pyramid->terms(l, s, linear)) plan.of_samples[s].push_back(term);
  return plan;
}

std::optional<TextureChunkFormat> read_chunk_format(ByteReader& reader, std::string& problem) {
  const auto refuse = [&](const char* what) {
    problem = what;
    return std::nullopt;
  };
  TextureChunkFormat format;
  const std::uint8_t kind = reader.byte();
  if (kind > 7 || (kind & 6) == 6) return refuse("the chunk has an unknown coder or unknown flags");
  format.coder = static_cast<ImageCoder>(kind & 1);
  format.linear = (kind & 2) != 0;
  format.width = reader.number(TextureChunkFormat::kSideMax);
  format.height = reader.number(TextureChunkFormat::kSideMax);
  if (format.width < 1 || format.height < 1) return refuse("a side of a texture is not between 1 and 16384 texels");
  const std::size_t dimensions = reader.byte(), levels = reader.byte();
  if (dimensions < 1 || dimensions > ParameterPyramid::kDimensionsMax)
    return refuse("the block has 0 dimensions, or more than 8");
  std::size_t samples = 1;
  for (std::size_t d = 0; d < dimensions; ++d) {
    format.sizes.push_back(reader.number(ParameterPyramid::kSamplesMax));
    if (format.sizes.back() < 1 || (samples *= format.sizes.back()) > ParameterPyramid::kSamplesMax)
      return refuse("the block has 0 samples, or more than 65536");
  }
  if (samples * levels << (format.linear ? dimensions : 0) > TextureChunkFormat::kTermsMax)
    return refuse("the samples are sums of more than 2^22 images in total");
  if (levels < 1 || levels > TextureChunkFormat::kBasisMax)
    return refuse("the chunk has 0 images, or more than 64 levels");
  for (std::size_t l = 0; l < levels; ++l) {
    if ((kind & 4) != 0) {
      const auto weights = reader.bytes(samples);
      format.basis.emplace_back(weights.begin(), weights.end());
    } else {
      format.levels.emplace_back();
      for (std::size_t d = 0; d < dimensions; ++d) format.levels.back().push_back(reader.byte());
    }
    format.level_codes.push_back(reader.byte());
  }
  if (reader.failed()) return refuse("the chunk ends within its header");
  std::size_t images = levels;
  if ((kind & 4) == 0) {
    const auto pyramid = ParameterPyramid::of(format.sizes, format.levels);
    if (!pyramid) return refuse("the levels do not form a pyramid over the block");
    images = pyramid->image_count();
  }
  if (images > TextureChunkFormat::kTexelsMax / (format.width * format.height))
    return refuse("the images have more than 2^28 texels in total");
  if (format.coder == ImageCoder::kDct) {
    format.side = reader.byte();
    if (!is_dct_side(format.side)) return refuse("the block size is not 8, 16 or 32 texels");
  }
  for (auto& part : format.rotation) part = reader.int16();
  for (auto& offset : format.offsets) offset = reader.int16();
  for (std::size_t i = format.step_code_count(); i > 0; --i) format.step_codes.push_back(reader.byte());
  if (reader.failed()) return refuse("the chunk ends within its header");
  return format;
}

}  // namespace multum
