// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/finest_levels.h"

#include <string>
#include <utility>
#include <vector>

#include <glm/vec3.hpp>

#include "host/base/error.h"
#include "runtime_gl/materials/mip_texture.h"
#include "runtime_gl/materials/normal_material.h"

namespace multum::gl {
namespace {

Texture upload(const GlFunctions& gl, const char* name, const LeftOutLevels& levels,
               const std::vector<glm::vec3>& texels, const SamplerSettings& sampler) {
  TexelPlane plane{levels.width, levels.height, {}};
  plane.texels.reserve(texels.size());
  for (const glm::vec3& texel : texels) plane.texels.emplace_back(texel, 1.0f);
  return upload_mips(gl, name, std::move(plane), levels.first_level, sampler);
}

}  // namespace

Texture upload_finest_normals(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage* source,
                              const SamplerSettings& sampler) {
  if (source == nullptr || source->width != levels.width || source->height != levels.height)
    throw Error(ErrorCode::kInput, "the finest levels of the baked map are not stored: found " +
                                       (source == nullptr ? std::string("no normal map")
                                                          : "a normal map of " + std::to_string(source->width) + " x " +
                                                                std::to_string(source->height)) +
                                       ", expected the one of " + std::to_string(levels.width) + " x " +
                                       std::to_string(levels.height) + " texels that was baked");
  return upload(gl, "the normal map", levels, source->normals, sampler);
}

bool has_finest_albedo(const LeftOutLevels& levels, const NormalImage& source) {
  return levels.has_colours && !source.albedo.empty();
}

Texture upload_finest_albedo(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage& source,
                             const SamplerSettings& sampler) {
  return upload(gl, "the albedo map", levels, source.albedo, sampler);
}

}  // namespace multum::gl
