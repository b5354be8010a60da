// SPDX-License-Identifier: Apache-2.0
// Levels of a texture as a renderer holds them, filtered as hardware does: what the pictures of a comparison are drawn
// from.
#pragma once

#include <vector>

#include "host/formats/image/plane_store.h"

namespace multum {

struct TextureLevel {
  int width = 0, height = 0;
  std::vector<float> texels;  // [row][column][channel]
};

/// Levels `first_level` and coarser, each repeated in both directions.
class LevelTexture {
 public:
  LevelTexture(int channel_count, int first_level) : channel_count_(channel_count), first_level_(first_level) {}

  int channel_count() const { return channel_count_; }
  int first_level() const { return first_level_; }
  std::vector<TextureLevel>& levels() { return levels_; }
  const std::vector<TextureLevel>& levels() const { return levels_; }
  /// Trilinear: `u`, `v` in units of the map, row 0 at v = 0; `level` from the first one on, clamped. `values`: a
  /// number a channel.
  void sample(double level, double u, double v, double* values) const;

 private:
  void add_bilinear(const TextureLevel& level, double u, double v, double share, double* values) const;

  int channel_count_, first_level_;
  std::vector<TextureLevel> levels_;
};

/// Averages of what texels cover: three channels of the normals, not normalised, and perceptual roughness. `material`:
/// null, or its first plane is alpha^2; else all have `alpha_squared`.
LevelTexture averaged_levels(const PlaneStore& normals, const PlaneStore* material, double alpha_squared,
                             int first_level);

}  // namespace multum
