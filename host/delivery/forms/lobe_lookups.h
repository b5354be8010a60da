// SPDX-License-Identifier: Apache-2.0
// Lobes of a baked file as @multum/three reads them (lobe_shading.js, runtime_gl/shaders/common/texture_filter.glsl),
// in double.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/delivery/forms/texture_lookups.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Levels from 1 of the map on, whose first one is level 0 here.
class LobeLevels {
 public:
  /// Of a baked file, those levels that are together within `bytes_max`. Throws Error(kInput).
  LobeLevels(const std::string& path, WrapMode wrap_s, WrapMode wrap_t, std::uint64_t bytes_max);

  int count() const { return count_; }
  const TextureFrame& frame() const { return frame_; }
  int finest_held() const { return finest_held_; }

  /// What addLobes() reads a place of a pixel at, before it is clamped. `along_x`, `along_y`: of the place, from one
  /// end of its part of the pixel to the other.
  double level_of(const glm::dvec2& along_x, const glm::dvec2& along_y, double bias) const;
  /// Columns and rows of `count` places of a pixel, a power of two, as multum_point_grid() has them.
  glm::ivec2 grid(int count, const glm::dvec2& along_x, const glm::dvec2& along_y) const;
  /// All lobes, (a r, a).
  std::vector<glm::dvec4> at(const glm::dvec2& place, double level) const;

 private:
  struct Layer {
    const LobeLevels& levels;
    std::size_t lobe;
    const TextureFrame& frame() const { return levels.frame_; }
    glm::dvec4 texel(int level, int x, int y) const;
  };

  int count_ = 0, finest_held_ = 0;
  TextureFrame frame_;
  std::vector<MovmfLevel> levels_;
};

}  // namespace multum
