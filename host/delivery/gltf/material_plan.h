// SPDX-License-Identifier: Apache-2.0
// Decides which of a glTF file's materials get fitted textures, and from what (glTF 2.0, section 3.9;
// docs/reference/gltf.md has the rules). A material's normal texture and its metallic-roughness texture are fitted
// together, and only where each texel of one lies over the texel of the other; all else stays as it is, with the
// reason.
#pragma once

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/delivery/gltf/gltf_asset.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// What is fitted together. Materials with the same have the same textures after.
struct LobeSource {
  std::size_t normal_image = 0;
  std::optional<std::size_t> surface_image;  // metallic-roughness; none: roughness_factor everywhere
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // of both, beyond their borders
  double normal_scale = 1.0;                                            // of x and y
  double roughness_factor = 1.0;                                        // times what the image has
  bool has_occlusion = false;  // red of surface_image is a material's occlusion
  bool is_anisotropic = false;

  auto operator<=>(const LobeSource&) const = default;
};

/// Coordinates of a texture: its set, and what KHR_texture_transform makes of them.
struct TextureCoordinates {
  std::uint64_t set = 0;
  std::array<double, 2> offset{0.0, 0.0}, scale{1.0, 1.0};
  double rotation = 0.0;

  bool operator==(const TextureCoordinates&) const = default;
  bool keeps_axes() const { return rotation == 0.0 && scale[0] > 0.0 && scale[1] > 0.0; }
};

struct MaterialPlan {
  std::string name;                // "bricks", or "material 3"
  std::string kept;                // why it stays as it is; empty: it is fitted
  std::size_t source = 0;          // in GltfPlan::sources
  TextureCoordinates coordinates;  // of what is fitted
  std::vector<std::string> notes;
  bool is_bad = false;    // `kept` is a fault of the model, which is warned of
  bool is_plain = false;  // `kept` is that its own mips are as near: they are read by a trilinear filter
};

struct GltfPlan {
  std::vector<LobeSource> sources;
  // By source: the base colour over the same texels, where all materials of the source have the same.
  std::vector<std::optional<std::size_t>> colour_images;
  std::vector<MaterialPlan> materials;  // by index
};

/// Throws Error(kInput) for materials that are not as glTF has them.
GltfPlan plan_gltf(const GltfAsset& asset, bool is_anisotropic);

}  // namespace multum
