// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/normal_material.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/lobes/lobe_family.h"
#include "host/foundation/base/error.h"
#include "runtime_gl/materials/mip_texture.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/texture_binder.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

// Limits slopes in the same way as bakes of moments, so that one texel at the horizon does not dominate its neighbours.
glm::vec2 slope(const glm::vec3& n) {
  const float z = std::max(n.z, kSlopeZMin);
  return {-n.x / z, -n.y / z};
}

glm::vec3 finest_normal(const glm::vec3& mean, bool has_roughness) {
  const float size = glm::length(mean);
  if (!(size > 0.0f)) return {0.0f, 0.0f, 1.0f};
  return has_roughness ? mean / std::max(size, 1.0f) : mean / size;
}

// Solves c = 1 - alpha^2 / 2 for the roughness, where alpha = roughness^2 (host/formats/image/material_maps.h).
float roughness_of_length(float size) { return std::pow(2.0f * std::clamp(1.0f - size, 0.0f, 0.5f), 0.25f); }

TexelPlane weight_plane(const NormalImage& image) {
  const auto count = static_cast<std::size_t>(image.weight_count);
  TexelPlane plane{image.width, image.height, std::vector<glm::vec4>(image.normals.size(), glm::vec4(0.0f))};
  for (std::size_t i = 0; i < plane.texels.size(); ++i)
    for (std::size_t k = 0; k < count; ++k)
      plane.texels[i][static_cast<glm::length_t>(k)] = image.weights[i * count + k];
  return plane;
}

ShaderParts reference_shader_parts(NormalMaterial::Sampling sampling) {
  using Sampling = NormalMaterial::Sampling;
  ShaderParts parts{{"MULTUM_REFERENCE"}, {shader_common_footprint_glsl, shader_surface_normals_glsl}};
  if (sampling == Sampling::kInterpolated) parts.flags.push_back("MULTUM_INTERPOLATED");
  if (sampling == Sampling::kBlended || sampling == Sampling::kFootprint) parts.flags.push_back("MULTUM_DRAWN_TEXEL");
  if (sampling == Sampling::kFootprint) parts.flags.push_back("MULTUM_FOOTPRINT");
  return parts;
}

ShaderParts baseline_shader_parts(Baseline baseline) {
  switch (baseline) {
    case Baseline::kMip: return {{"MULTUM_MIP"}, {shader_surface_normals_glsl}};
    case Baseline::kToksvig: return moment_shader_parts(MomentShading::kToksvig);
    case Baseline::kLean: return moment_shader_parts(MomentShading::kLean);
    case Baseline::kLeanJacobian: return moment_shader_parts(MomentShading::kLeanJacobian);
  }
  return {};
}

}  // namespace

NormalImage finest_normals(const MovmfMipmap& mipmap) {
  MULTUM_CHECK(!mipmap.levels.empty() && mipmap.header.first_level == 0);
  const MovmfLevel& level = mipmap.levels.front();
  const LobeFamily& family = lobe_family(mipmap.header.representation);
  NormalImage image{level.width, level.height, {}, {}, mipmap.header.wrap_s, mipmap.header.wrap_t};
  const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
  for (std::size_t i = 0; i < texels; ++i) {
    glm::vec3 normal(0.0f);
    glm::vec3 colour(0.0f);
    for (const auto& lobe : level.lobes) normal += glm::vec3(lobe[i]);
    normal = family.normal_of_finest(normal, mipmap.header.has_roughness);
    for (const auto& lobe_colour : level.colours) colour += lobe_colour[i];
    image.normals.push_back(finest_normal(normal, mipmap.header.has_roughness));
    if (mipmap.has_colours()) image.albedo.push_back(colour);
  }
  image.has_roughness = mipmap.header.has_roughness;
  image.weight_count = mipmap.header.weight_count;
  image.weights.resize(texels * static_cast<std::size_t>(mipmap.header.weight_count));
  for (const auto& weights : level.weights)
    std::transform(weights.begin(), weights.end(), image.weights.begin(), image.weights.begin(), std::plus<>());
  return image;
}

NormalImage finest_normals(const MomentMipmap& mipmap) {
  MULTUM_CHECK(!mipmap.levels.empty() && mipmap.header.first_level == 0);
  const MomentLevel& level = mipmap.levels.front();
  NormalImage image{level.width, level.height, {}, level.colours, mipmap.header.wrap_s, mipmap.header.wrap_t};
  for (const glm::vec3& normal : level.normals)
    image.normals.push_back(finest_normal(normal, mipmap.header.has_roughness));
  image.has_roughness = mipmap.header.has_roughness;
  image.weight_count = mipmap.header.weight_count;
  image.weights = level.weights;
  return image;
}

NormalImage finest_normals(const ShMipmap& mipmap) {
  MULTUM_CHECK(!mipmap.levels.empty() && mipmap.header.first_level == 0);
  const ShLevel& level = mipmap.levels.front();
  NormalImage image{level.width, level.height, {}, level.colours, mipmap.header.wrap_s, mipmap.header.wrap_t};
  for (const glm::vec4& band : level.parts[0]) {  // of l = 1: y, z, x
    const glm::vec3 n(band.z, band.x, band.y);
    image.normals.push_back(finest_normal(n / kShNormalFactor, mipmap.header.has_roughness));
  }
  image.has_roughness = mipmap.header.has_roughness;
  image.weight_count = mipmap.header.weight_count;
  image.weights = level.weights;
  return image;
}

NormalMaterial::NormalMaterial(const GlFunctions& gl, const NormalImage& image, Sampling sampling, float anisotropy)
    : sampling_(sampling), wrap_s_(image.wrap_s), wrap_t_(image.wrap_t) {
  MULTUM_CHECK(image.normals.size() == static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  MULTUM_CHECK(image.albedo.empty() || image.albedo.size() == image.normals.size());
  const bool mipmapped = sampling == Sampling::kMipmapped;
  const bool has_levels = mipmapped || sampling == Sampling::kFootprint;
  const int level_count = has_levels ? mip_level_count(image.width, image.height) : 1;
  const SamplerSettings sampler{image.wrap_s, image.wrap_t, has_levels, anisotropy};
  TexelPlane normals{image.width, image.height, {}};
  TexelPlane slopes{image.width, image.height, {}};
  TexelPlane roughness{image.width, image.height, {}};
  const bool has_roughness_map = mipmapped && image.has_roughness;
  for (const glm::vec3& given : image.normals) {
    const float size = glm::length(given);
    const glm::vec3 n = has_roughness_map && size > 0.0f ? given / size : given;
    if (has_roughness_map) roughness.texels.emplace_back(roughness_of_length(size), 0.0f, 0.0f, 1.0f);
    const glm::vec2 b = slope(n);
    normals.texels.emplace_back(n, b.x * b.y);
    if (mipmapped) slopes.texels.emplace_back(b.x, b.y, b.x * b.x, b.y * b.y);
  }
  normals_.emplace(upload_mips(gl, "the normals", std::move(normals), level_count, sampler));
  if (mipmapped) slopes_.emplace(upload_mips(gl, "the slopes", std::move(slopes), level_count, sampler));
  if (has_roughness_map)
    roughness_.emplace(upload_mips(gl, "the roughness", std::move(roughness), level_count, sampler));
  has_roughness_ = image.has_roughness;
  weight_count_ = image.weight_count;
  if (weight_count_ > 0) weights_.emplace(upload_mips(gl, "the weights", weight_plane(image), level_count, sampler));
  if (image.albedo.empty()) return;
  TexelPlane albedo{image.width, image.height, {}};
  for (const glm::vec3& colour : image.albedo) albedo.texels.emplace_back(colour, 1.0f);
  albedo_.emplace(upload_mips(gl, "the albedo", std::move(albedo), level_count, sampler));
}

void NormalMaterial::set_baseline(Baseline baseline) {
  MULTUM_CHECK(slopes_.has_value());
  baseline_ = baseline;
}

ShaderParts NormalMaterial::shader_parts() const {
  ShaderParts parts = slopes_.has_value() ? baseline_shader_parts(baseline_) : reference_shader_parts(sampling_);
  if (albedo_.has_value()) parts.flags.push_back("MULTUM_COLOURS");
  if (has_roughness_) parts.flags.push_back(roughness_.has_value() ? "MULTUM_ROUGHNESS_MAP" : "MULTUM_ROUGHNESS");
  add_basis_flag(parts);
  return parts;
}

int NormalMaterial::bind(const ShaderProgram& shader) const {
  TextureBinder binder(shader);
  binder.bind("u_normals", normals_);
  binder.bind("u_slopes", slopes_);
  binder.bind("u_albedo", albedo_);
  binder.bind("u_roughness", roughness_);
  shader.set("u_wrap_s", static_cast<int>(wrap_s_));  // values in the order of WrapMode
  shader.set("u_wrap_t", static_cast<int>(wrap_t_));
  if (is_of_basis()) binder.bind("u_weights", weights_);
  return binder.next_unit();
}

}  // namespace multum::gl
