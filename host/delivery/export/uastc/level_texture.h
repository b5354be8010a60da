// SPDX-License-Identifier: Apache-2.0
// A LevelFile as a texture that pictures are drawn with.
#pragma once

#include <cstdint>
#include <vector>

#include "host/delivery/export/uastc/level_file.h"
#include "host/delivery/forms/texture_lookups.h"

namespace multum {

/// Levels that are small enough are held in memory, others read texel by texel.
class LevelFileTexture : public SharesTexture {
 public:
  /// `file` must outlive it. `bytes_max`: of what is held.
  LevelFileTexture(const LevelFile& file, const TextureFrame& frame, std::uint64_t bytes_max);

  glm::dvec4 texel(int level, int x, int y) const override;

 private:
  const LevelFile& file_;
  std::vector<std::vector<std::uint8_t>> held_;  // by level; empty: on disk
};

}  // namespace multum
