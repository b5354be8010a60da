// SPDX-License-Identifier: Apache-2.0
// Defines a baked file of planar Gaussians on the GPU (Tan et al. 2005) as textures of lobes. Tan's BRDF shades these
// lobes (shaders/surface/gmm.glsl).
#pragma once

#include <memory>

#include "runtime_gl/materials/movmf_material.h"

namespace multum::gl {

class GmmMaterial : public MovmfMaterial {
 public:
  using MovmfMaterial::MovmfMaterial;
  const char* name() const override { return "gmm"; }
  ShaderParts shader_parts() const override;
  int budgeted_lobes() const override { return 0; }
};

/// Returns a GmmMaterial or a MovmfMaterial, depending on the mipmap's lobe family.
std::unique_ptr<MovmfMaterial> make_lobe_material(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy,
                                                  const NormalImage* source = nullptr);

}  // namespace multum::gl
