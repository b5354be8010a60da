// SPDX-License-Identifier: Apache-2.0
// Writes fitted textures into the JSON of a glTF file. Objects without other uses are replaced in place. In all other
// cases, new objects are appended. Indices and unknown data do not change.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/delivery/gltf/glb_layout.h"
#include "host/delivery/gltf/material_plan.h"
#include "host/delivery/gltf/texture_encoding.h"

namespace multum {

/// The new textures of a LobeSource. If a member is empty, the old texture is kept.
struct SourceTextures {
  std::optional<EncodedTexture> normal, surface, anisotropy;
  std::optional<EncodedTexture> lobes, lobe_colours;  // for MULTUM_lobes
};

struct RewrittenGltf {
  GltfJson json;
  ViewContents contents;
  std::vector<std::string> left_outside;  // URIs of images of unknown types, which remain separate files
};

/// `textures` has one entry per source.
RewrittenGltf rewrite_gltf(const GltfAsset& asset, const GltfPlan& plan, const std::vector<SourceTextures>& textures);

}  // namespace multum
