// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/materials/ggx_lobe_texture.h"

#include "host/formats/brdf/ggx_lobe.h"

namespace multum::gl {

Texture make_ggx_lobe_texture(const GlFunctions& gl) {
  Texture texture(gl, "GGX over lobes", {kGgxLobeTableSide, kGgxLobeTableSide, 1, TexelFormat::kRgba16f},
                  {WrapMode::kClamp, WrapMode::kClamp, true, 1.0f});
  texture.upload_rows(0, 0, kGgxLobeTableSide, ggx_lobe_table().data());
  return texture;
}

}  // namespace multum::gl
