// SPDX-License-Identifier: Apache-2.0
// Looks up lobes of a baked file in double precision, as @multum/three does (lobe_shading.js,
// runtime_gl/shaders/common/texture_filter.glsl).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/delivery/forms/texture_lookups.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// The map's levels 1 and coarser. Level 0 of this object is level 1 of the map.
class LobeLevels {
 public:
  /// Loads as many levels of a baked file as fit together into `bytes_max`. Throws Error(kInput).
  LobeLevels(const std::string& path, WrapMode wrap_s, WrapMode wrap_t, std::uint64_t bytes_max);
  /// Takes the levels of a bake in memory.
  LobeLevels(MovmfMipmap baked, WrapMode wrap_s, WrapMode wrap_t);

  int count() const { return count_; }
  bool has_colours() const { return !levels_.empty() && !levels_.back().colours.empty(); }
  const TextureFrame& frame() const { return frame_; }
  int finest_held() const { return finest_held_; }

  /// Returns the level at which addLobes() reads one of a pixel's places, before the level is clamped. `along_x` and
  /// `along_y` are the changes of the texture coordinates across the part of the pixel that belongs to this place.
  double level_of(const glm::dvec2& along_x, const glm::dvec2& along_y, double bias) const;
  /// Returns the numbers of columns and rows of the grid in which multum_point_grid() arranges the `count` shading
  /// points of a pixel. `count` must be a power of two.
  glm::ivec2 grid(int count, const glm::dvec2& along_x, const glm::dvec2& along_y) const;
  /// Returns all lobes, (a r, a).
  std::vector<glm::dvec4> at(const glm::dvec2& place, double level) const;
  /// Returns `a` times the luminance of the colour for each lobe. The file must have colours.
  std::vector<double> luminances(const glm::dvec2& place, double level) const;
  /// Returns the luminance of the lobe that is closest to a unit normal of the map. The lobe is taken from the texel at
  /// the place on the finest loaded level. Level 1 has one lobe for each normal that it covers.
  double finest_luminance(const glm::dvec2& place, const glm::dvec3& normal) const;

 private:
  PixelTaps taps_of(const glm::dvec2& place, double level) const;

  struct Layer {
    const LobeLevels& levels;
    std::size_t lobe;
    glm::dvec4 texel(int level, int x, int y) const;
    glm::dvec4 linear(int level, const glm::dvec2& place) const;
  };
  struct ColourLayer {  // luminance in x
    const LobeLevels& levels;
    std::size_t lobe;
    glm::dvec4 texel(int level, int x, int y) const;
    glm::dvec4 linear(int level, const glm::dvec2& place) const;
  };

  int count_ = 0, finest_held_ = 0;
  TextureFrame frame_;
  std::vector<MovmfLevel> levels_;
};

}  // namespace multum
