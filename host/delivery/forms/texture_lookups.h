// SPDX-License-Identifier: Apache-2.0
// Looks up texture levels in double precision, in the same way as the samplers of engines (OpenGL 4.6, section 8.14;
// EXT_texture_filter_anisotropic).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

/// The size of a texture and its wrap modes.
struct TextureFrame {
  int width = 0, height = 0, level_count = 0;
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;
};

/// Samples a level bilinearly. `place` is from 0 to 1 across the image, and `texel` returns a texel of column x and
/// row y.
template <typename Texel>
glm::dvec4 linear_lookup(const TextureFrame& frame, int level, const glm::dvec2& place, const Texel& texel) {
  const int width = mip_level_size(frame.width, level), height = mip_level_size(frame.height, level);
  const double x = place.x * width - 0.5, y = place.y * height - 0.5;
  const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
  const auto [left, right] = TexelPair::at(x0, width, frame.wrap_s);
  const auto [above, below] = TexelPair::at(y0, height, frame.wrap_t);
  const double u = x - x0, v = y - y0;
  return (1.0 - v) * ((1.0 - u) * texel(left, above) + u * texel(right, above)) +
         v * ((1.0 - u) * texel(left, below) + u * texel(right, below));
}

/// The levels of a texture, whose channels are shares from 0 to 1. All functions can be called from any number of
/// threads at once.
class SharesTexture {
 public:
  explicit SharesTexture(const TextureFrame& frame) : frame_(frame) {}
  virtual ~SharesTexture() = default;

  const TextureFrame& frame() const { return frame_; }
  virtual glm::dvec4 texel(int level, int x, int y) const = 0;
  /// Samples a level bilinearly, as linear_lookup() does. Textures in memory can do this faster.
  virtual glm::dvec4 linear(int level, const glm::dvec2& place) const {
    return linear_lookup(frame_, level, place, [&](int x, int y) { return texel(level, x, y); });
  }

 private:
  TextureFrame frame_;
};

/// The places and levels at which a texture is read for a pixel. The pixel's value is the mean of the values at these
/// places. All textures of one size use the same places and levels.
struct PixelTaps {
  std::array<int, 2> levels{};  // the finer and the coarser level
  double coarser_share = 0.0;
  std::vector<glm::dvec2> places;

  /// Chooses taps like the samplers of engines. `along_x` and `along_y` are the changes of the texture coordinates from
  /// a pixel to the next one in x and in y. `bias` is the number of octaves that are added to the level, and it does
  /// not move the taps.
  static PixelTaps of(const glm::dvec2& place, const glm::dvec2& along_x, const glm::dvec2& along_y,
                      const TextureFrame& frame, int anisotropy_max, double bias);

  template <typename Texture>
  glm::dvec4 mean(const Texture& texture) const {
    glm::dvec4 sum(0.0);
    for (const glm::dvec2& place : places) {
      if (coarser_share < 1.0) sum += (1.0 - coarser_share) * texture.linear(levels[0], place);
      if (coarser_share > 0.0) sum += coarser_share * texture.linear(levels[1], place);
    }
    return sum / static_cast<double>(places.size());
  }
};

}  // namespace multum
