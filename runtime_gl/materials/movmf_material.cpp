// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/movmf_material.h"

#include <utility>

#include "host/formats/sampling/blue_noise.h"
#include "host/foundation/base/error.h"
#include "runtime_gl/materials/texture_binder.h"
#include "runtime_gl/materials/weight_texture.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

void check_mipmap(const MovmfMipmap& mipmap) {
  const auto lobe_count = static_cast<std::size_t>(mipmap.lobe_count());
  if (lobe_count < 1 || lobe_count > kLobeCountMax)
    throw Error(ErrorCode::kInput, "cannot draw a baked map with " + std::to_string(lobe_count) +
                                       " lobes: expected 1 to " + std::to_string(kLobeCountMax));
  if (mipmap.header.first_level < 0 || static_cast<std::size_t>(mipmap.header.first_level) >= mipmap.levels.size())
    throw Error(ErrorCode::kInput, "cannot draw a baked map of " + std::to_string(mipmap.levels.size()) +
                                       " levels: its first level is " + std::to_string(mipmap.header.first_level));
  for (std::size_t l = static_cast<std::size_t>(mipmap.header.first_level); l < mipmap.levels.size(); ++l) {
    const MovmfLevel& level = mipmap.levels[l];
    const int width = mip_level_size(mipmap.width(), static_cast<int>(l));
    const int height = mip_level_size(mipmap.height(), static_cast<int>(l));
    const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    bool good = level.width == width && level.height == height && level.lobes.size() == lobe_count &&
                level.colours.size() == (mipmap.has_colours() ? lobe_count : 0);
    for (const auto& lobe : level.lobes) good = good && lobe.size() == texels;
    for (const auto& colour : level.colours) good = good && colour.size() == texels;
    good = good && level.weights.size() == (mipmap.header.weight_count > 0 ? lobe_count : 0);
    for (const auto& weights : level.weights)
      good = good && weights.size() == texels * static_cast<std::size_t>(mipmap.header.weight_count);
    if (!good)
      throw Error(ErrorCode::kInput, "level " + std::to_string(l) + " of the baked map does not have " +
                                         std::to_string(width) + " x " + std::to_string(height) + " texels of " +
                                         std::to_string(lobe_count) + " lobes");
  }
}

// Level 0 of a texture is the first stored level.
void upload_colours(Texture& texture, const MovmfMipmap& mipmap, std::size_t lobe) {
  for (int l = 0; l < texture.shape().level_count; ++l) {
    const std::vector<glm::vec3>& colours =
        mipmap.levels[static_cast<std::size_t>(mipmap.header.first_level + l)].colours[lobe];
    std::vector<glm::vec4> rgba;
    rgba.reserve(colours.size());
    for (const glm::vec3& colour : colours) rgba.emplace_back(colour, 1.0f);
    texture.upload_level(l, &rgba[0].x);
  }
}

}  // namespace

TexelFormat texel_format(StorageEncoding encoding) {
  switch (encoding) {
    case StorageEncoding::kSnorm16: return TexelFormat::kRgba16Snorm;
    case StorageEncoding::kHalf: return TexelFormat::kRgba16f;
    case StorageEncoding::kFloat: return TexelFormat::kRgba32f;
  }
  return TexelFormat::kRgba32f;
}

MovmfMaterial::MovmfMaterial(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy,
                             const NormalImage* source) {
  check_mipmap(mipmap);
  const auto lobe_count = static_cast<std::size_t>(mipmap.lobe_count());
  const int level_count = static_cast<int>(mipmap.levels.size()) - mipmap.header.first_level;
  const MovmfLevel& finest = mipmap.levels[static_cast<std::size_t>(mipmap.header.first_level)];
  const SamplerSettings sampler{mipmap.header.wrap_s, mipmap.header.wrap_t, true, anisotropy};
  const TextureShape shape{finest.width, finest.height, level_count, texel_format(mipmap.header.encoding)};
  lobe_count_ = mipmap.lobe_count();
  lobes_.reserve(lobe_count);
  for (std::size_t j = 0; j < lobe_count; ++j) {
    lobes_.emplace_back(gl, "lobe " + std::to_string(j), shape, sampler);
    for (int l = 0; l < level_count; ++l)
      lobes_[j].upload_level(l, &mipmap.levels[static_cast<std::size_t>(mipmap.header.first_level + l)].lobes[j][0].x);
  }
  const LeftOutLevels left_out{mipmap.width(), mipmap.height(), mipmap.header.first_level, mipmap.has_colours()};
  finest_.upload(gl, left_out, source, sampler);
  weight_count_ = mipmap.header.weight_count;
  if (mipmap.header.has_roughness) mean_cosine_ = mipmap.header.mean_cosine;
  weights_.reserve(lobe_count);
  for (std::size_t j = 0; weight_count_ > 0 && j < lobe_count; ++j) {
    std::vector<const std::vector<float>*> levels;
    for (int l = mipmap.header.first_level; l < mipmap.header.first_level + level_count; ++l)
      levels.push_back(&mipmap.levels[static_cast<std::size_t>(l)].weights[j]);
    weights_.push_back(upload_weights(gl, "weights of a lobe", shape, sampler, weight_count_, levels));
  }
  if (!mipmap.has_colours()) return;
  TextureShape colour_shape = shape;
  colour_shape.format =
      mipmap.header.encoding == StorageEncoding::kFloat ? TexelFormat::kRgba32f : TexelFormat::kRgba16f;
  colours_.reserve(lobe_count);
  for (std::size_t j = 0; j < lobe_count; ++j) {
    colours_.emplace_back(gl, "colour of lobe " + std::to_string(j), colour_shape, sampler);
    upload_colours(colours_[j], mipmap, j);
  }
}

void MovmfMaterial::set_layers(const GlFunctions& gl, const LobeTexture& texture, float anisotropy) {
  const LobeTextureHeader& header = texture.header;
  MULTUM_CHECK(static_cast<int>(header.lobes.size()) == lobe_count_ && colours_.empty() && weights_.empty());
  const TexelFormat format = header.texels == LobeTexels::kBlocks  ? TexelFormat::kBc5
                             : header.texels == LobeTexels::kRgba8 ? TexelFormat::kRgba8
                                                                   : TexelFormat::kRgba16f;
  const TextureShape shape{mip_level_size(header.map.width, header.map.first_level),
                           mip_level_size(header.map.height, header.map.first_level), header.level_count(), format,
                           header.layer_count()};
  layers_.emplace(gl, "layers of lobes", shape,
                  SamplerSettings{header.map.wrap_s, header.map.wrap_t, true, anisotropy});
  for (int l = 0; l < shape.level_count; ++l) layers_->upload_bytes(l, texture.levels[static_cast<std::size_t>(l)]);
  unpacking_ = header.lobes;
  has_black_border_ = header.map.wrap_s == WrapMode::kBlack || header.map.wrap_t == WrapMode::kBlack;
  lobes_.clear();
}

void MovmfMaterial::set_shade_first(bool shade_first) {
  MULTUM_CHECK(!shade_first || !(finest_.is_used() || layers_));
  shade_first_ = shade_first;
}

void MovmfMaterial::set_magnified(bool magnified) {
  MULTUM_CHECK(!magnified || !(finest_.is_used() || mean_cosine_));
  magnified_ = magnified;
}

int MovmfMaterial::budgeted_lobes() const { return shade_first_ || formula_ == LobeFormula::kPaper ? 0 : lobe_count_; }

void MovmfMaterial::set_drawn(const GlFunctions& gl, DrawnNoise noise) {
  drawn_ = noise;
  blue_noise_.reset();
  if (noise != DrawnNoise::kBlue) return;
  std::vector<float> texels;
  for (const std::uint8_t value : blue_noise()) texels.push_back(static_cast<float>(value) / 255.0f);
  blue_noise_.emplace(gl, "blue noise", TextureShape{kBlueNoiseSide, kBlueNoiseSide, 1, TexelFormat::kRgba32f},
                      SamplerSettings{WrapMode::kPeriodic, WrapMode::kPeriodic, false, 1.0f});
  blue_noise_->upload_level(0, texels.data());
}

void MovmfMaterial::set_mean_colours(Texture colours) {
  MULTUM_CHECK(colours_.empty());
  mean_colours_.emplace(std::move(colours));
}

ShaderParts MovmfMaterial::fetch_parts() const {
  ShaderParts parts{{"MULTUM_LOBE_COUNT " + std::to_string(lobe_count())}, {shader_surface_lobes_glsl}};
  if (!colours_.empty()) parts.flags.push_back("MULTUM_COLOURS");
  if (mean_colours_.has_value()) parts.flags.push_back("MULTUM_MEAN_COLOURS");
  if (shade_first_) parts.flags.push_back("MULTUM_SHADE_FIRST");
  if (layers_)
    parts.flags.push_back("MULTUM_LOBE_LAYERS " + std::to_string(layers_->shape().layer_count / lobe_count_));
  if (layers_ && !has_black_border_) parts.flags.push_back("MULTUM_WHOLE");
  MULTUM_CHECK(!drawn_ || !shade_first_);
  if (drawn_) {
    parts.flags.insert(parts.flags.end(), {"MULTUM_DRAWN_LOBE", "MULTUM_REFERENCE"});
    if (*drawn_ == DrawnNoise::kWhite) parts.flags.push_back("MULTUM_HASHED");
    parts.texts.insert(parts.texts.begin(), shader_common_blue_noise_glsl);
    parts.texts.insert(parts.texts.begin(), shader_common_footprint_glsl);
  }
  finest_.add_flags(parts);
  if (mean_cosine_) parts.flags.push_back("MULTUM_ROUGHNESS");
  add_basis_flag(parts);
  return parts;
}

ShaderParts MovmfMaterial::shader_parts() const {
  ShaderParts parts = fetch_parts();
  if (formula_ == LobeFormula::kPaper) parts.flags.push_back("MULTUM_PAPER");
  if (magnified_ && !shade_first_) parts.flags.push_back("MULTUM_MAGNIFIED");
  parts.texts.push_back(shader_surface_movmf_glsl);
  return parts;
}

int MovmfMaterial::bind(const ShaderProgram& shader) const {
  TextureBinder binder(shader);
  if (layers_) {
    binder.bind("u_lobe_layers", layers_);
    std::vector<float> numbers;
    for (const LobeUnpacking& lobe : unpacking_) {
      for (const glm::vec4& column : lobe.columns) numbers.insert(numbers.end(), &column.x, &column.x + 4);
      numbers.insert(numbers.end(), &lobe.offset.x, &lobe.offset.x + 4);
    }
    shader.set_floats("u_lobe_unpacking", numbers.data(), static_cast<int>(numbers.size()));
  } else {
    binder.bind("u_lobes", lobes_);
  }
  binder.bind("u_colours", colours_);
  if (is_of_basis()) binder.bind("u_weights", weights_);
  if (mean_cosine_) shader.set("u_mean_cosine", *mean_cosine_);
  finest_.bind(binder);
  binder.bind("u_mean_colours", mean_colours_);
  binder.bind("u_blue_noise", blue_noise_);
  return binder.next_unit();
}

}  // namespace multum::gl
