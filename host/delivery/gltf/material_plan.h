// SPDX-License-Identifier: Apache-2.0
// Decides which materials of a glTF file receive fitted textures, and from which inputs these are made (glTF 2.0,
// section 3.9; the rules are in docs/reference/gltf.md). A material's normal texture and metallic-roughness texture are
// fitted together if their texels cover the same places on the surface. Otherwise the material stays unchanged, and the
// reason is stated.
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

/// Inputs of one fit. Materials with equal inputs share the resulting textures.
struct LobeSource {
  std::size_t normal_image = 0;
  std::optional<std::size_t> surface_image;  // metallic-roughness image; without it, roughness_factor applies
                                             // everywhere
  // Wrap modes of both images.
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;
  double normal_scale = 1.0;      // scale of x and y
  double roughness_factor = 1.0;  // multiplies the image's roughness
  bool has_occlusion = false;     // true if red of surface_image is a material's occlusion
  bool is_anisotropic = false;

  auto operator<=>(const LobeSource&) const = default;
};

/// The set of texture coordinates, and the transform of KHR_texture_transform.
struct TextureCoordinates {
  std::uint64_t set = 0;
  std::array<double, 2> offset{0.0, 0.0}, scale{1.0, 1.0};
  double rotation = 0.0;

  bool operator==(const TextureCoordinates&) const = default;
  bool keeps_axes() const { return rotation == 0.0 && scale[0] > 0.0 && scale[1] > 0.0; }
};

struct MaterialPlan {
  std::string name;                // "bricks", or "material 3"
  std::string kept;                // reason why the material is unchanged; empty if it is fitted
  std::size_t source = 0;          // index into GltfPlan::sources
  TextureCoordinates coordinates;  // coordinates of the fitted textures
  std::vector<std::string> notes;
  bool is_bad = false;    // true if `kept` is a fault of the model and causes a warning
  bool is_plain = false;  // true if `kept` says that the material's own mips are equally good, because they are read
                          // with a trilinear filter
};

struct GltfPlan {
  std::vector<LobeSource> sources;
  // For each source, the base colour image, if it covers the same texels and all materials of the source use this
  // image.
  std::vector<std::optional<std::size_t>> colour_images;
  std::vector<MaterialPlan> materials;  // plan of each material, by its index
};

/// Throws Error(kInput) for materials that violate glTF.
GltfPlan plan_gltf(const GltfAsset& asset, bool is_anisotropic);

}  // namespace multum
