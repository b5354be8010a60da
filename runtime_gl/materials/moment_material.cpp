// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/moment_material.h"

#include <utility>
#include <vector>

#include <glm/vec4.hpp>

#include "host/foundation/base/error.h"
#include "runtime_gl/materials/texture_binder.h"
#include "runtime_gl/materials/weight_texture.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

void check_levels(const MomentMipmap& mipmap) {
  const BakedHeader& header = mipmap.header;
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const int width = mip_level_size(header.width, l), height = mip_level_size(header.height, l);
    const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const auto index = static_cast<std::size_t>(l);
    const bool good = index < mipmap.levels.size() && mipmap.levels[index].slopes.size() == texels &&
                      mipmap.levels[index].normals.size() == texels &&
                      mipmap.levels[index].colours.size() == (header.has_colours ? texels : 0) &&
                      mipmap.levels[index].weights.size() == texels * static_cast<std::size_t>(header.weight_count);
    if (!good)
      throw Error(ErrorCode::kInput, "level " + std::to_string(l) + " of the baked map does not have " +
                                         std::to_string(width) + " x " + std::to_string(height) + " texels of moments");
  }
}

// Makes a texture from texel(level, i). Its level 0 is the first stored level.
template <typename TexelOf>
Texture upload(const GlFunctions& gl, const char* name, const MomentMipmap& mipmap, const SamplerSettings& sampler,
               const TexelOf& texel) {
  const BakedHeader& header = mipmap.header;
  const TexelFormat format = header.encoding == StorageEncoding::kFloat ? TexelFormat::kRgba32f : TexelFormat::kRgba16f;
  Texture texture(gl, name,
                  {mip_level_size(header.width, header.first_level), mip_level_size(header.height, header.first_level),
                   header.level_count() - header.first_level, format},
                  sampler);
  for (int l = 0; l < texture.shape().level_count; ++l) {
    const MomentLevel& level = mipmap.levels[static_cast<std::size_t>(header.first_level + l)];
    std::vector<glm::vec4> texels;
    texels.reserve(level.normals.size());
    for (std::size_t i = 0; i < level.normals.size(); ++i) texels.push_back(texel(level, i));
    texture.upload_level(l, &texels[0].x);
  }
  return texture;
}

}  // namespace

MomentMaterial::MomentMaterial(const GlFunctions& gl, const MomentMipmap& mipmap, float anisotropy,
                               const NormalImage* source) {
  check_levels(mipmap);
  const BakedHeader& header = mipmap.header;
  const SamplerSettings sampler{header.wrap_s, header.wrap_t, true, anisotropy};
  means_.emplace(upload(gl, "mean normals", mipmap, sampler, [](const MomentLevel& level, std::size_t i) {
    return glm::vec4(level.normals[i], level.slopes[i].st);
  }));
  slopes_.emplace(upload(gl, "slopes", mipmap, sampler, [](const MomentLevel& level, std::size_t i) {
    const SlopeMoments& m = level.slopes[i];
    return glm::vec4(m.s, m.t, m.ss, m.tt);
  }));
  if (header.has_colours)
    colours_.emplace(upload(gl, "colours", mipmap, sampler,
                            [](const MomentLevel& level, std::size_t i) { return glm::vec4(level.colours[i], 1.0f); }));
  weight_count_ = header.weight_count;
  if (header.has_roughness) mean_cosine_ = header.mean_cosine;
  if (weight_count_ > 0) weights_.emplace(upload_weights(gl, means_->shape(), sampler, mipmap));
  const LeftOutLevels left_out{header.width, header.height, header.first_level, header.has_colours};
  finest_.upload(gl, left_out, source, sampler);
}

ShaderParts moment_shader_parts(MomentShading shading) {
  ShaderParts parts{
      {}, {brdf_shader_text("blinn_phong.glsl"), shader_common_moment_shading_glsl, shader_surface_normals_glsl}};
  parts.flags.push_back(shading == MomentShading::kToksvig ? "MULTUM_TOKSVIG" : "MULTUM_LEAN");
  if (shading == MomentShading::kLeanJacobian) parts.flags.push_back("MULTUM_JACOBIAN");
  return parts;
}

ShaderParts MomentMaterial::shader_parts() const {
  ShaderParts parts = moment_shader_parts(shading_);
  if (colours_.has_value()) parts.flags.push_back("MULTUM_COLOURS");
  finest_.add_flags(parts);
  if (mean_cosine_) parts.flags.push_back("MULTUM_ROUGHNESS");
  add_basis_flag(parts);
  return parts;
}

int MomentMaterial::bind(const ShaderProgram& shader) const {
  TextureBinder binder(shader);
  binder.bind("u_normals", means_);
  binder.bind("u_slopes", slopes_);
  binder.bind("u_albedo", colours_);
  if (is_of_basis()) binder.bind("u_weights", weights_);
  if (mean_cosine_) shader.set("u_mean_cosine", *mean_cosine_);
  finest_.bind(binder);
  return binder.next_unit();
}

}  // namespace multum::gl
