// SPDX-License-Identifier: Apache-2.0
// Defines a baked file of spherical harmonics on the GPU (docs/reference/file_format.md, "Spherical harmonics"). It is
// an array of textures with four coefficients per layer. If the file has colours or weights of basis BRDFs, there are
// textures of these too. An array is needed because only 16 samplers per shader are guaranteed, and order 8 would need
// 20. The textures have the levels of the file. Textures of the normal map replace levels that the file does not store.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/finest_levels.h"
#include "runtime_gl/materials/material.h"

namespace multum::gl {

struct NormalImage;

/// The methods for the cosine that multiplies the highlight (shaders/surface/sh.glsl).
enum class ShCosine { kMeanNormal, kMeanDirection, kIrradiance };

/// Returns the flags that common/sh_shading.glsl needs.
std::vector<std::string> sh_shading_flags(int order);

class ShMaterial : public Material {
 public:
  /// Uses RGBA16F for half and RGBA32F for float values. `source` is the baked map, which is used only if the file's
  /// first level is not 0. Throws Error(kInput) if a level has the wrong number of texels, or if `source` is missing or
  /// of another size.
  ShMaterial(const GlFunctions& gl, const ShMipmap& mipmap, float anisotropy, const NormalImage* source = nullptr);

  void set_cosine(ShCosine cosine) { cosine_ = cosine; }

  const char* name() const override { return "sh"; }
  ShaderParts shader_parts() const override;
  int bind(const ShaderProgram& shader) const override;
  int zonal_order() const override { return order_; }
  int weight_count() const override { return weight_count_; }

 private:
  const int order_;
  const WrapMode wrap_s_, wrap_t_;
  std::optional<Texture> harmonics_, colours_, weights_;
  FinestLevels finest_;
  int weight_count_ = 0;
  std::optional<float> mean_cosine_;  // set if a BRDF's width is included
  ShCosine cosine_ = ShCosine::kIrradiance;
};

}  // namespace multum::gl
