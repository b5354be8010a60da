// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/finest_levels.h"

#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "host/foundation/base/error.h"
#include "runtime_gl/materials/mip_texture.h"
#include "runtime_gl/materials/normal_material.h"

namespace multum::gl {
namespace {

Texture upload_map(const GlFunctions& gl, const char* name, const LeftOutLevels& levels,
                   const std::vector<glm::vec3>& texels, const SamplerSettings& sampler) {
  TexelPlane plane{levels.width, levels.height, {}};
  plane.texels.reserve(texels.size());
  for (const glm::vec3& texel : texels) plane.texels.emplace_back(texel, 1.0f);
  return upload_mips(gl, name, std::move(plane), levels.first_level, sampler);
}

}  // namespace

void FinestLevels::upload(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage* source,
                          const SamplerSettings& sampler) {
  if (levels.first_level == 0) return;
  if (source == nullptr || source->width != levels.width || source->height != levels.height)
    throw Error(ErrorCode::kInput, "the baked map does not store its finest levels: found " +
                                       (source == nullptr ? std::string("no normal map")
                                                          : "a normal map of " + std::to_string(source->width) + " x " +
                                                                std::to_string(source->height)) +
                                       ", expected the baked normal map of " + std::to_string(levels.width) + " x " +
                                       std::to_string(levels.height) + " texels");
  normals_.emplace(upload_map(gl, "the normal map", levels, source->normals, sampler));
  if (levels.has_colours && !source->albedo.empty())
    albedo_.emplace(upload_map(gl, "the albedo map", levels, source->albedo, sampler));
}

void FinestLevels::add_flags(ShaderParts& parts) const {
  if (normals_.has_value()) parts.flags.push_back("MULTUM_NORMAL_MAP");
  if (albedo_.has_value()) parts.flags.push_back("MULTUM_ALBEDO_MAP");
}

void FinestLevels::bind(TextureBinder& binder) const {
  binder.bind("u_normal_map", normals_);
  binder.bind("u_albedo_map", albedo_);
}

}  // namespace multum::gl
