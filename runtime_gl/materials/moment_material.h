// SPDX-License-Identifier: Apache-2.0
// Defines a baked file of moments on the GPU (docs/reference/file_format.md, "Moments"). The material has a texture of
// the mean normal and the moment E[b_s b_t], a texture of the other slope moments, and a texture of colours if the file
// has colours. The textures have the levels of the file. Textures of the normal map replace levels that the file does
// not store.
#pragma once

#include <optional>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/finest_levels.h"
#include "runtime_gl/materials/material.h"

namespace multum::gl {

struct NormalImage;

/// The shading methods of moments (shaders/common/moment_shading.glsl).
enum class MomentShading { kToksvig, kLean, kLeanJacobian };

/// Returns the flags of surface/normals.glsl.
ShaderParts moment_shader_parts(MomentShading shading);

class MomentMaterial : public Material {
 public:
  /// Uses RGBA16F for half and RGBA32F for float values. `source` is the baked map, which is used only if the file's
  /// first level is not 0. Throws Error(kInput) if a level has the wrong number of texels, or if `source` is missing or
  /// of another size.
  MomentMaterial(const GlFunctions& gl, const MomentMipmap& mipmap, float anisotropy,
                 const NormalImage* source = nullptr);

  void set_shading(MomentShading shading) { shading_ = shading; }

  const char* name() const override { return "moments"; }
  ShaderParts shader_parts() const override;
  int bind(const ShaderProgram& shader) const override;
  int weight_count() const override { return weight_count_; }

 private:
  std::optional<Texture> weights_;
  int weight_count_ = 0;
  std::optional<float> mean_cosine_;  // set if roughness is included
  std::optional<Texture> means_;      // E[n]; w = E[b_s b_t]
  std::optional<Texture> slopes_;     // E[b_s], E[b_t], E[b_s^2], E[b_t^2]
  std::optional<Texture> colours_;
  FinestLevels finest_;
  MomentShading shading_ = MomentShading::kLeanJacobian;
};

}  // namespace multum::gl
