// SPDX-License-Identifier: Apache-2.0
// An affine map of an object's own texture coordinates onto the texture that was inferred for it (Hakura et al. 2000,
// section 3.4): six values, and where a periodic direction was cut open.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <nlohmann/json_fwd.hpp>

#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// Largest side of pictures and textures that GPUs take.
constexpr int kGpuSideMax = 16384;

/// Coordinates across the texture (0..1, v upwards) = linear * (u', v') + offset, where u' = u, or in a direction with
/// a branch cut u' = u - floor(u - cut), in [cut, cut + 1).
struct TextureMapping {
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};
  std::array<bool, 2> has_cut{false, false};
  std::array<double, 2> cut{0.0, 0.0};
  WrapMode wrap_s = WrapMode::kClamp, wrap_t = WrapMode::kClamp;
  int width = 1, height = 1;          // texels
  double stretch_max = 0.0;           // largest singular value of texels to pixels over all visible pixels
  int stretch_rounds = 0;             // of scaling by it
  std::size_t visible_pixels = 0;     // of all views together
  std::size_t degenerate_pixels = 0;  // of them, those of triangles that are a line in the texture or seen edge-on
};

/// Whole periods that bring a triangle to its side of the cuts: where it straddles one, which no visible triangle does,
/// its middle decides. `uvs` [vertices], `indices` three a triangle.
glm::dvec2 cut_shift(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices, std::size_t triangle,
                     const TextureMapping& mapping);

/// Texture coordinates of every triangle's corners under the mapping, three a triangle: a cut may give a vertex two.
std::vector<glm::vec2> mapped_corners(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices,
                                      const TextureMapping& mapping);

void to_json(nlohmann::json& json, const TextureMapping& mapping);
/// Throws nlohmann::json::exception for what is missing or of another type; Error(kInput) for values out of range.
void from_json(const nlohmann::json& json, TextureMapping& mapping);

}  // namespace multum
