// SPDX-License-Identifier: Apache-2.0
// Counts who uses a glTF file's textures, images and buffer views, so that what nobody else needs can be replaced where
// it stands: no index changes, and whatever an extension that nobody here knows refers to stays what it was.
#pragma once

#include <cstdint>
#include <map>
#include <set>

#include "host/delivery/gltf/gltf_asset.h"

namespace multum {

struct GltfUses {
  std::map<std::uint64_t, int> textures, images, views;  // uses by index: of glTF itself and of extensions known here
  // Every integer within extensions that are not known here: each may be an index of anything.
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

/// Extras are not looked at: they are of programs that know the file.
GltfUses gltf_uses(const GltfJson& json);

/// Extensions of a texture that name another image for it.
bool is_image_extension(const std::string& name);

}  // namespace multum
