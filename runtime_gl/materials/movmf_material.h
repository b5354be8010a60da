// SPDX-License-Identifier: Apache-2.0
// A baked file on the GPU: one texture a lobe (a r, a), and one a lobe for premultiplied colours if the file has them.
// Level for level as they are in the file; trilinear filtering of these values is exact (host/asset/movmf_mipmap.h).
#pragma once

#include <vector>

#include "host/asset/movmf_mipmap.h"
#include "runtime_gl/gl/texture.h"

namespace multum::gl {

/// snorm16 -> RGBA16_SNORM, half -> RGBA16F, float -> RGBA32F.
TexelFormat texel_format(StorageEncoding encoding);

class MovmfMaterial {
 public:
  /// Throws Error(kInput) when the mipmap has no levels, or their sizes do not halve as they should.
  MovmfMaterial(const GlFunctions& gl, const MovmfMipmap& mipmap, float anisotropy);

  /// Lobes take the units 0, 1, ..., colours those after them.
  void bind() const;
  int lobe_count() const { return static_cast<int>(lobes_.size()); }
  bool has_colours() const { return !colours_.empty(); }
  const Texture& lobe(int index) const { return lobes_[static_cast<std::size_t>(index)]; }

 private:
  std::vector<Texture> lobes_;
  std::vector<Texture> colours_;
};

}  // namespace multum::gl
