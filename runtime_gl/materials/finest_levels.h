// SPDX-License-Identifier: Apache-2.0
// The levels that a baked file leaves to the normal map (docs/FORMAT.md, "The finest levels"), as textures of that map:
// levels 0 to the first that is stored less one.
#pragma once

#include "runtime_gl/gl/texture.h"

namespace multum::gl {

struct NormalImage;

/// Of the map that was baked.
struct LeftOutLevels {
  int width, height;
  int first_level;  // the finest that is stored, above 0
  bool has_colours;
};

/// (mean normal, 1). Throws Error(kInput) when `source` is null or of another size.
Texture upload_finest_normals(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage* source,
                              const SamplerSettings& sampler);

/// Are there colours to go with them?
bool has_finest_albedo(const LeftOutLevels& levels, const NormalImage& source);
Texture upload_finest_albedo(const GlFunctions& gl, const LeftOutLevels& levels, const NormalImage& source,
                             const SamplerSettings& sampler);

}  // namespace multum::gl
