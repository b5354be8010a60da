// SPDX-License-Identifier: Apache-2.0
// Presents a LevelFile as a texture for drawing pictures.
#pragma once

#include <cstdint>
#include <vector>

#include "host/delivery/export/uastc/level_file.h"
#include "host/delivery/forms/texture_lookups.h"

namespace multum {

/// Holds small levels in memory, and reads texels of other levels from disk.
class LevelFileTexture : public SharesTexture {
 public:
  /// `file` must outlive this object. `bytes_max` limits the size of the levels in memory.
  LevelFileTexture(const LevelFile& file, const TextureFrame& frame, std::uint64_t bytes_max);

  glm::dvec4 texel(int level, int x, int y) const override;

 private:
  const LevelFile& file_;
  std::vector<std::vector<std::uint8_t>> held_;  // levels in memory; empty for a level on disk
};

}  // namespace multum
