// SPDX-License-Identifier: Apache-2.0
// Counts the uses of a glTF file's textures, images and buffer views, to find objects with a single use, which can be
// replaced in place. No index changes then, so references in unknown extensions stay valid.
#pragma once

#include <cstdint>
#include <map>
#include <set>

#include "host/delivery/gltf/gltf_asset.h"

namespace multum {

struct GltfUses {
  std::map<std::uint64_t, int> textures, images, views;  // uses by index, in glTF itself and in known extensions
  // All integers in unknown extensions, because each may be an index.
  std::set<std::uint64_t> unknown;

  int texture_uses(std::uint64_t index) const { return uses(textures, index); }
  int image_uses(std::uint64_t index) const { return uses(images, index); }
  int view_uses(std::uint64_t index) const { return uses(views, index); }

 private:
  int uses(const std::map<std::uint64_t, int>& of, std::uint64_t index) const {
    const auto found = of.find(index);
    return (found == of.end() ? 0 : found->second) + (unknown.contains(index) ? 1 : 0);
  }
};

/// Counts the uses. Ignores "extras", which belong to specific programs.
GltfUses gltf_uses(const GltfJson& json);

/// Returns whether a texture extension names another image for the texture.
bool is_image_extension(const std::string& name);

}  // namespace multum
