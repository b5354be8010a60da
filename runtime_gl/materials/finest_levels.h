// SPDX-License-Identifier: Apache-2.0
// Makes textures of the normal map for the levels that a baked file does not store, from level 0 to the level before
// the first stored one (docs/reference/file_format.md, "The finest levels").
#pragma once

#include <optional>

#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/material.h"
#include "runtime_gl/materials/texture_binder.h"

namespace multum::gl {

struct NormalImage;

/// The levels of the baked map that the file does not store.
struct LeftOutLevels {
  int width, height;
  int first_level;  // the finest stored level
  bool has_colours;
};

class FinestLevels {
 public:
  /// Must be called only once. Does nothing if all levels are stored. Throws Error(kInput) if `source` is needed but is
  /// null or has another size.
  void upload(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage* source,
              const SamplerSettings& sampler);

  bool is_used() const { return normals_.has_value(); }
  void add_flags(ShaderParts& parts) const;
  void bind(TextureBinder& binder) const;

 private:
  std::optional<Texture> normals_;  // (mean normal, 1)
  std::optional<Texture> albedo_;   // set if both the file and the source have colours
};

}  // namespace multum::gl
