// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/uastc/level_texture.h"

#include <algorithm>
#include <array>

#include "host/formats/asset/baked_file.h"
#include "host/foundation/base/size_of.h"

namespace multum {

LevelFileTexture::LevelFileTexture(const LevelFile& file, const TextureFrame& frame, std::uint64_t bytes_max)
    : SharesTexture(frame), file_(file), held_(size_of(frame.level_count)) {
  for (int level = frame.level_count; level-- > 0;) {
    const std::uint64_t bytes = file.offset(level + 1) - file.offset(level);
    if (bytes > bytes_max) break;
    bytes_max -= bytes;
    held_[size_of(level)] = file.read_rows(level, 0, mip_level_size(frame.height, level));
  }
}

glm::dvec4 LevelFileTexture::texel(int level, int x, int y) const {
  const std::vector<std::uint8_t>& held = held_[size_of(level)];
  const std::size_t at = size_of(y) * size_of(mip_level_size(frame().width, level)) + size_of(x);
  std::array<std::uint8_t, 4> code;
  if (held.empty()) code = file_.read_texel(level, x, y);
  else std::copy_n(held.begin() + static_cast<std::ptrdiff_t>(4 * at), 4, code.begin());
  return glm::dvec4(code[0], code[1], code[2], code[3]) / 255.0;
}

}  // namespace multum
