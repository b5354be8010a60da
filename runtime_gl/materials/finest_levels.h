// SPDX-License-Identifier: Apache-2.0
// The levels that a baked file leaves to the normal map (docs/reference/file_format.md, "The finest levels"), as
// textures of that map: levels 0 to the first that is stored less one.
#pragma once

#include <optional>

#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/material.h"
#include "runtime_gl/materials/texture_binder.h"

namespace multum::gl {

struct NormalImage;

/// Of the map that was baked.
struct LeftOutLevels {
  int width, height;
  int first_level;  // the finest that is stored
  bool has_colours;
};

class FinestLevels {
 public:
  /// Once; nothing where all levels are stored. Throws Error(kInput) when `source` is needed and null, or of another
  /// size.
  void upload(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage* source,
              const SamplerSettings& sampler);

  bool is_used() const { return normals_.has_value(); }
  void add_flags(ShaderParts& parts) const;
  void bind(TextureBinder& binder) const;

 private:
  std::optional<Texture> normals_;  // (mean normal, 1)
  std::optional<Texture> albedo_;   // where the file has colours, and the source
};

}  // namespace multum::gl
