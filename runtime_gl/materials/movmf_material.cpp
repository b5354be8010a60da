// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/movmf_material.h"

#include "host/base/error.h"

namespace multum::gl {
namespace {

void check_mipmap(const MovmfMipmap& mipmap) {
  const auto lobe_count = static_cast<std::size_t>(mipmap.lobe_count());
  if (lobe_count < 1 || lobe_count > kLobeCountMax)
    throw Error(ErrorCode::kInput, "a baked map with " + std::to_string(lobe_count) + " lobes; 1 to " +
                                       std::to_string(kLobeCountMax) + " can be drawn");
  for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
    const MovmfLevel& level = mipmap.levels[l];
    const int width = mip_level_size(mipmap.width(), static_cast<int>(l));
    const int height = mip_level_size(mipmap.height(), static_cast<int>(l));
    const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    bool good = level.width == width && level.height == height && level.lobes.size() == lobe_count &&
                level.colours.size() == (mipmap.has_colours() ? lobe_count : 0);
    for (const auto& lobe : level.lobes) good = good && lobe.size() == texels;
    for (const auto& colour : level.colours) good = good && colour.size() == texels;
    if (!good)
      throw Error(ErrorCode::kInput, "level " + std::to_string(l) + " of the baked map is not " +
                                         std::to_string(width) + " x " + std::to_string(height) + " texels of " +
                                         std::to_string(lobe_count) + " lobes");
  }
}

void upload_colours(Texture& texture, const MovmfMipmap& mipmap, std::size_t lobe) {
  for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
    std::vector<glm::vec4> rgba;
    rgba.reserve(mipmap.levels[l].colours[lobe].size());
    for (const glm::vec3& colour : mipmap.levels[l].colours[lobe]) rgba.emplace_back(colour, 1.0f);
    texture.upload_level(static_cast<int>(l), &rgba[0].x);
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

MovmfMaterial::MovmfMaterial(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy) {
  check_mipmap(mipmap);
  const auto lobe_count = static_cast<std::size_t>(mipmap.lobe_count());
  const int level_count = static_cast<int>(mipmap.levels.size());
  const SamplerSettings sampler{mipmap.wrap_s, mipmap.wrap_t, true, anisotropy};
  const TextureShape shape{mipmap.width(), mipmap.height(), level_count, texel_format(mipmap.encoding)};
  lobes_.reserve(lobe_count);
  for (std::size_t j = 0; j < lobe_count; ++j) {
    lobes_.emplace_back(gl, "lobe " + std::to_string(j), shape, sampler);
    for (int l = 0; l < level_count; ++l)
      lobes_[j].upload_level(l, &mipmap.levels[static_cast<std::size_t>(l)].lobes[j][0].x);
  }
  if (!mipmap.has_colours()) return;
  TextureShape colour_shape = shape;
  colour_shape.format = mipmap.encoding == StorageEncoding::kFloat ? TexelFormat::kRgba32f : TexelFormat::kRgba16f;
  colours_.reserve(lobe_count);
  for (std::size_t j = 0; j < lobe_count; ++j) {
    colours_.emplace_back(gl, "colour of lobe " + std::to_string(j), colour_shape, sampler);
    upload_colours(colours_[j], mipmap, j);
  }
}

void MovmfMaterial::bind() const {
  int unit = 0;
  for (const Texture& lobe : lobes_) lobe.bind(unit++);
  for (const Texture& colour : colours_) colour.bind(unit++);
}

}  // namespace multum::gl
