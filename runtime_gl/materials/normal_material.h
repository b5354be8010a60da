// SPDX-License-Identifier: Apache-2.0
// Makes textures of the finest normals, for reference pictures and for the methods that users have today. These methods
// are averaged normals (with Toksvig's rule) and slope moments (LEAN, Olano and Baker 2010). All textures are RGBA32F,
// so that a baseline's errors come from its method and not from storage.
#pragma once

#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/material.h"

namespace multum::gl {

/// The finest level, which the caller provides. The first row is at the image's top.
struct NormalImage {
  int width = 0;
  int height = 0;
  std::vector<glm::vec3> normals;  // unit, tangent space; shorter if `has_roughness`
  std::vector<glm::vec3> albedo;   // linear; empty means white
  WrapMode wrap_s = WrapMode::kPeriodic;
  WrapMode wrap_t = WrapMode::kPeriodic;
  bool has_roughness = false;       // lengths of normals hold a BRDF's width
  int weight_count = 0;             // number of basis BRDFs
  std::vector<float> weights = {};  // weight_count per texel
};

/// Returns level 0 of a baked file, which must be stored, as normals. The normals are the sums of the lobes, normalised
/// unless roughness is included. Also returns the sums of colours and weights.
NormalImage finest_normals(const MovmfMipmap& mipmap);
/// These functions return level 0 of a file of moments, and of a file of spherical harmonics, in the same way.
NormalImage finest_normals(const MomentMipmap& mipmap);
NormalImage finest_normals(const ShMipmap& mipmap);

/// The methods that users have today, which use averages.
enum class Baseline { kMip, kToksvig, kLean, kLeanJacobian };

class NormalMaterial : public Material {
 public:
  /// The references differ in the normal that a sample uses. kNearest uses the nearest texel of level 0. kBlended
  /// chooses one of the four surrounding texels at random, with their bilinear weights at level 0 as probabilities.
  /// kInterpolated uses the normal interpolated between the four texels. kFootprint chooses at random one of the texels
  /// that the scene's TextureFilter averages (exact distributions, common/footprint.glsl). For baselines, kMipmapped
  /// uses box-filtered mips.
  enum class Sampling { kNearest, kBlended, kInterpolated, kFootprint, kMipmapped };
  NormalMaterial(const GlFunctions& gl, const NormalImage& image, Sampling sampling, float anisotropy);

  /// Sets the shading method for mipmapped textures.
  void set_baseline(Baseline baseline);

  const char* name() const override { return slopes_.has_value() ? "baseline" : "reference"; }
  ShaderParts shader_parts() const override;
  bool samples_light() const override { return !slopes_.has_value(); }
  bool samples_footprint() const override { return sampling_ == Sampling::kFootprint; }
  int bind(const ShaderProgram& shader) const override;
  int weight_count() const override { return weight_count_; }

 private:
  std::optional<Texture> normals_;  // mean n; w = E[b_s b_t]
  std::optional<Texture> slopes_;   // E[b_s], E[b_t], E[b_s^2], E[b_t^2], b = -n_xy / n_z
  std::optional<Texture> albedo_;
  std::optional<Texture> weights_;
  int weight_count_ = 0;
  bool has_roughness_ = false;
  // Sets a texture of perceptual roughness, (roughness, 0, 0, 1), whose levels are averaged in the same way as an
  // engine's roughness map. The texture is used with unit normals, and only by kMipmapped.
  std::optional<Texture> roughness_;
  Baseline baseline_ = Baseline::kMip;
  Sampling sampling_;
  WrapMode wrap_s_, wrap_t_;
};

}  // namespace multum::gl
