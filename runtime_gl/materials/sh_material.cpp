// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/sh_material.h"

#include <cstdio>
#include <numbers>
#include <vector>

#include <glm/gtc/type_ptr.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/gauss_legendre.h"
#include "runtime_gl/materials/texture_binder.h"
#include "runtime_gl/materials/weight_texture.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

void check_levels(const ShMipmap& mipmap) {
  const BakedHeader& header = mipmap.header;
  for (int l = header.first_level; l < header.level_count(); ++l) {
    const int width = mip_level_size(header.width, l), height = mip_level_size(header.height, l);
    const std::size_t texels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    const auto index = static_cast<std::size_t>(l);
    bool good = index < mipmap.levels.size() &&
                mipmap.levels[index].parts.size() == static_cast<std::size_t>(sh_part_count(mipmap.order)) &&
                mipmap.levels[index].colours.size() == (header.has_colours ? texels : 0) &&
                mipmap.levels[index].weights.size() == texels * static_cast<std::size_t>(header.weight_count);
    for (std::size_t part = 0; good && part < mipmap.levels[index].parts.size(); ++part)
      good = mipmap.levels[index].parts[part].size() == texels;
    if (!good)
      throw Error(ErrorCode::kInput, "level " + std::to_string(l) + " of the baked map does not have " +
                                         std::to_string(width) + " x " + std::to_string(height) +
                                         " texels of spherical harmonics");
  }
}

}  // namespace

std::vector<std::string> sh_shading_flags(int order) {
  const std::vector<ShStep> steps = sh_recurrence(order);
  std::string text = "MULTUM_SH_STEPS vec2[" + std::to_string(steps.size()) + "](";
  for (std::size_t i = 0; i < steps.size(); ++i) {
    char step[64];
    std::snprintf(step, sizeof(step), "%svec2(%.9e, %.9e)", i == 0 ? "" : ", ", static_cast<double>(steps[i].a),
                  static_cast<double>(steps[i].b));
    text += step;
  }
  return {"MULTUM_SH_ORDER " + std::to_string(order), text + ")"};
}

ShMaterial::ShMaterial(const GlFunctions& gl, const ShMipmap& mipmap, float anisotropy, const NormalImage* source)
    : order_(mipmap.order), wrap_s_(mipmap.header.wrap_s), wrap_t_(mipmap.header.wrap_t) {
  check_levels(mipmap);
  const BakedHeader& header = mipmap.header;
  const SamplerSettings sampler{header.wrap_s, header.wrap_t, true, anisotropy};
  TextureShape shape{mip_level_size(header.width, header.first_level),
                     mip_level_size(header.height, header.first_level), header.level_count() - header.first_level,
                     header.encoding == StorageEncoding::kFloat ? TexelFormat::kRgba32f : TexelFormat::kRgba16f};
  TextureShape layers = shape;
  layers.layer_count = sh_part_count(order_);
  harmonics_.emplace(gl, "spherical harmonics", layers, sampler);
  if (header.has_colours) colours_.emplace(gl, "colours", shape, sampler);
  for (int l = 0; l < shape.level_count; ++l) {
    const ShLevel& level = mipmap.levels[static_cast<std::size_t>(header.first_level + l)];
    for (int part = 0; part < layers.layer_count; ++part)
      harmonics_->upload_layer(l, part, &level.parts[static_cast<std::size_t>(part)][0].x);
    std::vector<glm::vec4> rgba;
    for (const glm::vec3& colour : level.colours) rgba.emplace_back(colour, 1.0f);
    if (colours_) colours_->upload_level(l, &rgba[0].x);
  }
  weight_count_ = header.weight_count;
  if (header.has_roughness) mean_cosine_ = header.mean_cosine;
  if (weight_count_ > 0) weights_.emplace(upload_weights(gl, shape, sampler, mipmap));
  const LeftOutLevels left_out{header.width, header.height, header.first_level, header.has_colours};
  finest_.upload(gl, left_out, source, sampler);
}

namespace {

// The nodes that integrate products of two functions of this order over the sphere (surface/sh.glsl).
std::string sphere_nodes_flag(int order) {
  const QuadratureRule rule = gauss_legendre(order + 1);
  std::string text = "MULTUM_SH_NODES vec2[" + std::to_string(rule.nodes.size()) + "](";
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    char node[64];
    std::snprintf(node, sizeof(node), "%svec2(%.9e, %.9e)", i == 0 ? "" : ", ", rule.nodes[i],
                  rule.weights[i] * 2.0 * std::numbers::pi / (2 * order + 1));
    text += node;
  }
  return text + ")";
}

}  // namespace

ShaderParts ShMaterial::shader_parts() const {
  ShaderParts parts{sh_shading_flags(order_), {shader_common_sh_shading_glsl, shader_surface_sh_glsl}};
  parts.flags.push_back("MULTUM_ZONAL_ORDER " + std::to_string(order_));
  parts.flags.push_back(sphere_nodes_flag(order_));
  if (cosine_ == ShCosine::kIrradiance) parts.flags.push_back("MULTUM_SH_IRRADIANCE");
  if (cosine_ == ShCosine::kMeanDirection) parts.flags.push_back("MULTUM_SH_DIRECTION");
  if (wrap_s_ == WrapMode::kBlack) parts.flags.push_back("MULTUM_BLACK_S");
  if (wrap_t_ == WrapMode::kBlack) parts.flags.push_back("MULTUM_BLACK_T");
  if (colours_.has_value()) parts.flags.push_back("MULTUM_COLOURS");
  finest_.add_flags(parts);
  if (mean_cosine_) parts.flags.push_back("MULTUM_ROUGHNESS");
  add_basis_flag(parts);
  return parts;
}

int ShMaterial::bind(const ShaderProgram& shader) const {
  TextureBinder binder(shader);
  binder.bind("u_harmonics", harmonics_);
  binder.bind("u_colours", colours_);
  if (is_of_basis()) binder.bind("u_weights", weights_);
  if (mean_cosine_) {
    shader.set("u_mean_cosine", *mean_cosine_);
    std::vector<glm::vec3> diffuse;
    for (const double a : zonal_lambert_of_rough(order_, static_cast<double>(*mean_cosine_)))
      diffuse.emplace_back(static_cast<float>(a));
    shader.set_vec3("u_diffuse_zonal", glm::value_ptr(diffuse[0]), order_ + 1);
  }
  finest_.bind(binder);
  return binder.next_unit();
}

}  // namespace multum::gl
