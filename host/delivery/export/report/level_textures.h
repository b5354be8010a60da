// SPDX-License-Identifier: Apache-2.0
// Holds texture levels like a renderer and filters them like hardware. The pictures of a comparison are drawn with
// these textures.
#pragma once

#include <vector>

#include "host/formats/image/plane_store.h"

namespace multum {

struct TextureLevel {
  int width = 0, height = 0;
  std::vector<float> texels;  // [row][column][channel]
};

/// Levels `first_level` and coarser. Each level repeats in both directions.
class LevelTexture {
 public:
  LevelTexture(int channel_count, int first_level) : channel_count_(channel_count), first_level_(first_level) {}

  int channel_count() const { return channel_count_; }
  int first_level() const { return first_level_; }
  std::vector<TextureLevel>& levels() { return levels_; }
  const std::vector<TextureLevel>& levels() const { return levels_; }
  /// Samples trilinearly. `u` and `v` are in units of the map, with row 0 at v = 0. `level` is clamped to the stored
  /// levels. `values` receives one number per channel.
  void sample(double level, double u, double v, double* values) const;

 private:
  void add_bilinear(const TextureLevel& level, double u, double v, double share, double* values) const;

  int channel_count_, first_level_;
  std::vector<TextureLevel> levels_;
};

/// Averages the finest texels that each texel covers. The result has three channels of normals, which are not
/// normalized, and perceptual roughness. The first plane of `material` is alpha^2. If `material` is null, all texels
/// have `alpha_squared`.
LevelTexture averaged_levels(const PlaneStore& normals, const PlaneStore* material, double alpha_squared,
                             int first_level);

}  // namespace multum
