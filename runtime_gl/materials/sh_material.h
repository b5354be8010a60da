// SPDX-License-Identifier: Apache-2.0
// A baked file of spherical harmonics on the GPU (docs/reference/file_format.md, "Spherical harmonics"): one array of
// textures, four coefficients a layer, and textures of colours and of weights of basis BRDFs if the file has them. An
// array, since a shader has 16 samplers for sure and order 8 takes 20. Level for level as they are in the file. Levels
// that the file leaves to the normal map are textures of that map.
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

/// What the highlight is multiplied by for the cosine of its normals (shaders/surface/sh.glsl).
enum class ShCosine { kMeanNormal, kMeanDirection, kIrradiance };

/// The flags that common/sh_shading.glsl needs.
std::vector<std::string> sh_shading_flags(int order);

class ShMaterial : public Material {
 public:
  /// half -> RGBA16F, float -> RGBA32F. `source`: the map that was baked; needed, and used, when the file's first level
  /// is not 0. Throws Error(kInput) when a level has not the texels that it should, or `source` is missing or of
  /// another size.
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
  std::optional<float> mean_cosine_;  // where a BRDF's width is in
  ShCosine cosine_ = ShCosine::kIrradiance;
};

}  // namespace multum::gl
