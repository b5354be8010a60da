// SPDX-License-Identifier: Apache-2.0
// Defines an affine map of an object's own texture coordinates onto its inferred texture (Hakura et al. 2000, section
// 3.4). The map has six values, and the branch cuts of periodic directions.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>
#include <nlohmann/json_fwd.hpp>

#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// The largest side of pictures and textures that GPUs support.
constexpr int kGpuSideMax = 16384;

/// Coordinates across the texture (0..1, v upwards) are linear * (u', v') + offset. Here u' = u. In a direction with a
/// branch cut, u' = u - floor(u - cut), which is in [cut, cut + 1).
struct TextureMapping {
  glm::dmat2 linear{1.0};
  glm::dvec2 offset{0.0};
  std::array<bool, 2> has_cut{false, false};
  std::array<double, 2> cut{0.0, 0.0};
  WrapMode wrap_s = WrapMode::kClamp, wrap_t = WrapMode::kClamp;
  int width = 1, height = 1;          // texels
  double stretch_max = 0.0;           // largest singular value of the map from texels to pixels over all visible pixels
  int stretch_rounds = 0;             // number of scalings for the stretch limit
  std::size_t visible_pixels = 0;     // visible pixels in all views together
  std::size_t degenerate_pixels = 0;  // visible pixels of triangles that are edge-on, or only a line in the texture
};

/// Returns the number of whole periods by which a triangle is moved to its side of the cuts. Visible triangles never
/// cross a cut. For other triangles, the position of the middle decides. `uvs` has one entry per vertex, and `indices`
/// has three per triangle.
glm::dvec2 cut_shift(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices, std::size_t triangle,
                     const TextureMapping& mapping);

/// Returns the mapped texture coordinates of every triangle's corners, three per triangle. Coordinates are not stored
/// per vertex, because a vertex at a cut has two of them.
std::vector<glm::vec2> mapped_corners(const std::vector<glm::vec2>& uvs, const std::vector<std::uint32_t>& indices,
                                      const TextureMapping& mapping);

void to_json(nlohmann::json& json, const TextureMapping& mapping);
/// Throws nlohmann::json::exception for missing values and wrong types. Throws Error(kInput) for values out of range.
void from_json(const nlohmann::json& json, TextureMapping& mapping);

}  // namespace multum
