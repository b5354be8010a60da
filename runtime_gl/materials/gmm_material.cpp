// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/gmm_material.h"

#include "host/formats/asset/lobes/lobe_family.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {

ShaderParts GmmMaterial::shader_parts() const {
  ShaderParts parts = fetch_parts();
  parts.texts.push_back(shader_common_gmm_shading_glsl);
  parts.texts.push_back(shader_surface_gmm_glsl);
  return parts;
}

std::unique_ptr<MovmfMaterial> make_lobe_material(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy,
                                                  const NormalImage* source) {
  if (lobe_family(mipmap.header.representation).is_planar)
    return std::make_unique<GmmMaterial>(gl, mipmap, anisotropy, source);
  return std::make_unique<MovmfMaterial>(gl, mipmap, anisotropy, source);
}

}  // namespace multum::gl
