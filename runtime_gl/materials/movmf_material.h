// SPDX-License-Identifier: Apache-2.0
// Defines a baked file on the GPU. There is one texture (a r, a) per lobe, and one texture of premultiplied colours per
// lobe if the file has colours. The textures have the levels of the file. Trilinear filtering of their values is exact
// (host/formats/asset/lobes/movmf_mipmap.h). Textures of the normal map replace levels that the file does not store
// (movmf_shading.glsl, multum_normal_map_share).
#pragma once

#include <optional>
#include <vector>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/textures/lobe_texture.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/finest_levels.h"
#include "runtime_gl/materials/material.h"

namespace multum::gl {

struct NormalImage;

/// Returns RGBA16_SNORM for snorm16, RGBA16F for half, and RGBA32F for float.
TexelFormat texel_format(StorageEncoding encoding);

enum class LobeFormula {
  kProduct,  // multiplies mean cosines (docs/contributing/ALGORITHMS.md)
  kPaper,    // Han et al. 2007, equation 20 and Algorithm 2; only for Blinn-Phong
};

enum class DrawnNoise {
  kBlue,   // host/formats/sampling/blue_noise.h
  kWhite,  // a hash of each pixel, for comparison
};

class MovmfMaterial : public Material {
 public:
  /// `source` is the baked map, which is used only if the mipmap's first level is not 0. Throws Error(kInput) if the
  /// mipmap has no levels, if their sizes do not halve correctly, or if `source` is missing or has another size.
  MovmfMaterial(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy,
                const NormalImage* source = nullptr);

  /// Replaces the lobe textures by `texture`, which has the data in a GPU format from which `mipmap` was unpacked.
  void set_layers(const GlFunctions& gl, const LobeTexture& texture, float anisotropy);

  void set_formula(LobeFormula formula) { formula_ = formula; }
  /// Shades the lobes of each texel of a trilinear footprint and mixes the results, instead of mixing lobes. This is
  /// for lobes that are not aligned. The file must begin at level 0.
  void set_shade_first(bool shade_first);

  /// Where level 0 is magnified, draws the surface of an interpolated normal map instead of mixing the light of the
  /// surrounding texels. This works only for files that begin at level 0, without roughness, and not for planar
  /// Gaussians.
  void set_magnified(bool magnified);

  /// Draws one random normal per pixel and frame. Its lobe is chosen with the amplitude as probability. This is for
  /// renderers that store one normal. Use it with Renderer::draw_reference(), with one frame per sample. Do not use it
  /// with environments or shade_first.
  void set_drawn(const GlFunctions& gl, DrawnNoise noise);

  /// Sets linear colours of the map's texels for mipmaps without colours. The colours are filtered like a plain
  /// texture, and all lobes share them.
  void set_mean_colours(Texture colours);

  const char* name() const override { return "movmf"; }
  ShaderParts shader_parts() const override;
  int bind(const ShaderProgram& shader) const override;
  bool samples_light() const override { return drawn_.has_value(); }
  bool samples_footprint() const override { return drawn_.has_value(); }
  int weight_count() const override { return weight_count_; }
  int budgeted_lobes() const override;
  int lobe_count() const { return lobe_count_; }
  const Texture& lobe(int index) const { return lobes_[static_cast<std::size_t>(index)]; }

 protected:
  /// Returns the flags and texts that fetch lobes of any family.
  ShaderParts fetch_parts() const;

 private:
  std::vector<Texture> lobes_;  // empty if there are layers
  std::optional<Texture> layers_;
  std::vector<LobeUnpacking> unpacking_;
  bool has_black_border_ = false;  // only for layers: amplitudes fall to 0 at the border
  int lobe_count_ = 0;
  std::vector<Texture> colours_;
  std::vector<Texture> weights_;
  int weight_count_ = 0;
  std::optional<float> mean_cosine_;  // set if roughness is included
  FinestLevels finest_;
  std::optional<Texture> mean_colours_;
  LobeFormula formula_ = LobeFormula::kProduct;
  bool shade_first_ = false;
  bool magnified_ = false;
  std::optional<DrawnNoise> drawn_;
  std::optional<Texture> blue_noise_;
};

}  // namespace multum::gl
