// SPDX-License-Identifier: Apache-2.0
// A baked file on the GPU: one texture a lobe (a r, a), and one a lobe for premultiplied colours if the file has them.
// Level for level as they are in the file; trilinear filtering of these values is exact (host/asset/movmf_mipmap.h).
// Levels that the file leaves to the normal map are textures of that map (movmf_shading.glsl, multum_movmf_normal_map).
#pragma once

#include <optional>
#include <vector>

#include "host/asset/movmf_mipmap.h"
#include "runtime_gl/gl/texture.h"

namespace multum::gl {

struct NormalImage;

/// snorm16 -> RGBA16_SNORM, half -> RGBA16F, float -> RGBA32F.
TexelFormat texel_format(StorageEncoding encoding);

class MovmfMaterial {
 public:
  /// `source`: the map that was baked; needed, and used, when the mipmap's first level is not 0. Throws Error(kInput)
  /// when the mipmap has no levels, their sizes do not halve as they should, or `source` is missing or of another size.
  MovmfMaterial(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy,
                const NormalImage* source = nullptr);

  /// Lobes take the units 0, 1, ..., then come colours, the normal map and the albedo map, those that there are.
  void bind() const;
  int lobe_count() const { return static_cast<int>(lobes_.size()); }
  bool has_colours() const { return !colours_.empty(); }
  bool has_normal_map() const { return normal_map_.has_value(); }
  bool has_albedo_map() const { return albedo_map_.has_value(); }
  const Texture& lobe(int index) const { return lobes_[static_cast<std::size_t>(index)]; }

 private:
  std::vector<Texture> lobes_;
  std::vector<Texture> colours_;
  std::optional<Texture> normal_map_;  // (mean normal, 1), levels 0 to the first that is stored less one
  std::optional<Texture> albedo_map_;
};

}  // namespace multum::gl
