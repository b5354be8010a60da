// SPDX-License-Identifier: Apache-2.0
// A baked file on the GPU: one texture a lobe (a r, a), and one a lobe for premultiplied colours if the file has them.
// Level for level as they are in the file; trilinear filtering of these values is exact
// (host/formats/asset/lobes/movmf_mipmap.h). Levels that the file leaves to the normal map are textures of that map
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

/// snorm16 -> RGBA16_SNORM, half -> RGBA16F, float -> RGBA32F.
TexelFormat texel_format(StorageEncoding encoding);

enum class LobeFormula {
  kProduct,  // mean cosines multiplied (docs/contributing/ALGORITHMS.md)
  kPaper,    // Han et al. 2007, equation 20 and Algorithm 2; of Blinn-Phong
};

enum class DrawnNoise {
  kBlue,   // host/formats/sampling/blue_noise.h
  kWhite,  // a hash of each pixel: for comparison
};

class MovmfMaterial : public Material {
 public:
  /// `source`: the map that was baked; needed, and used, when the mipmap's first level is not 0. Throws Error(kInput)
  /// when the mipmap has no levels, their sizes do not halve as they should, or `source` is missing or of another size.
  MovmfMaterial(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy,
                const NormalImage* source = nullptr);

  /// The lobes of `texture`, of which `mipmap` was unpacked, from now on as they lie on a GPU.
  void set_layers(const GlFunctions& gl, const LobeTexture& texture, float anisotropy);

  void set_formula(LobeFormula formula) { formula_ = formula; }
  /// Shades the lobes of each texel of a trilinear footprint and mixes what comes of them, instead of mixing lobes: for
  /// lobes that are not aligned. Of files that begin at level 0.
  void set_shade_first(bool shade_first);

  /// Where level 0 is magnified, draws the surface that an interpolated normal map shows, instead of the light of the
  /// texels around. Of files that begin at level 0, without roughness in; planar Gaussians do not.
  void set_magnified(bool magnified);

  /// One normal a pixel and frame, drawn from the lobes by amplitude: what a renderer that keeps one normal has. Drawn
  /// by Renderer::draw_reference(), a frame a sample; without environments and shade_first.
  void set_drawn(const GlFunctions& gl, DrawnNoise noise);

  /// Linear colours of the map's texels, filtered plainly, for all lobes alike: of mipmaps without colours.
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
  /// The flags and texts that fetch lobes, whatever they are.
  ShaderParts fetch_parts() const;

 private:
  std::vector<Texture> lobes_;  // none where there are layers
  std::optional<Texture> layers_;
  std::vector<LobeUnpacking> unpacking_;
  bool has_black_border_ = false;  // of layers: amplitudes fall to 0 there
  int lobe_count_ = 0;
  std::vector<Texture> colours_;
  std::vector<Texture> weights_;
  int weight_count_ = 0;
  std::optional<float> mean_cosine_;  // with roughness in
  FinestLevels finest_;
  std::optional<Texture> mean_colours_;
  LobeFormula formula_ = LobeFormula::kProduct;
  bool shade_first_ = false;
  bool magnified_ = false;
  std::optional<DrawnNoise> drawn_;
  std::optional<Texture> blue_noise_;
};

}  // namespace multum::gl
