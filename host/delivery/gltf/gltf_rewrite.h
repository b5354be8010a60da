// SPDX-License-Identifier: Apache-2.0
// Puts fitted textures into a glTF file's JSON. What nobody else uses is replaced where it stands, all else is added at
// the end: no index changes, and nothing that is not understood is touched.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/delivery/gltf/glb_layout.h"
#include "host/delivery/gltf/material_plan.h"
#include "host/delivery/gltf/texture_encoding.h"

namespace multum {

/// Of a LobeSource; what there is none of stays as it was.
struct SourceTextures {
  std::optional<EncodedTexture> normal, surface, anisotropy;
  std::optional<EncodedTexture> lobes, lobe_colours;  // for MULTUM_lobes
};

struct RewrittenGltf {
  GltfJson json;
  ViewContents contents;
  std::vector<std::string> left_outside;  // URIs of images that are of no known kind, and stay files beside
};

/// `textures`: by source.
RewrittenGltf rewrite_gltf(const GltfAsset& asset, const GltfPlan& plan, const std::vector<SourceTextures>& textures);

}  // namespace multum
