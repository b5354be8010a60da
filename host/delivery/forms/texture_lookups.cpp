// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/texture_lookups.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace multum {

int wrapped_texel(int i, int size, WrapMode mode) {
  if (mode == WrapMode::kClamp || mode == WrapMode::kBlack) return std::clamp(i, 0, size - 1);
  const int period = mode == WrapMode::kPeriodic ? size : 2 * size;
  i = (i % period + period) % period;
  return i < size ? i : period - 1 - i;
}

SharesTexture::SharesTexture(const LevelFile& file, const TextureFrame& frame, std::uint64_t bytes_max)
    : file_(file), frame_(frame), held_(size_of(frame.level_count)) {
  for (int level = frame.level_count; level-- > 0;) {
    const std::uint64_t bytes = file.offset(level + 1) - file.offset(level);
    if (bytes > bytes_max) break;
    bytes_max -= bytes;
    held_[size_of(level)] = file.read_rows(level, 0, mip_level_size(frame.height, level));
  }
}

glm::dvec4 SharesTexture::texel(int level, int x, int y) const {
  const std::vector<std::uint8_t>& held = held_[size_of(level)];
  const std::size_t at = size_of(y) * size_of(mip_level_size(frame_.width, level)) + size_of(x);
  std::array<std::uint8_t, 4> code;
  if (held.empty()) code = file_.read_texel(level, x, y);
  else std::copy_n(held.begin() + static_cast<std::ptrdiff_t>(4 * at), 4, code.begin());
  return glm::dvec4(code[0], code[1], code[2], code[3]) / 255.0;
}

PixelTaps PixelTaps::of(const glm::dvec2& place, const glm::dvec2& along_x, const glm::dvec2& along_y,
                        const TextureFrame& frame, int anisotropy_max, double bias) {
  const glm::dvec2 size(frame.width, frame.height);
  const double length_x = glm::length(along_x * size), length_y = glm::length(along_y * size);
  const double longer = std::max({length_x, length_y, 1e-12}), shorter = std::min(length_x, length_y);
  const int count = static_cast<int>(
      std::clamp(std::ceil(longer / std::max(shorter, 1e-12) - 1e-3), 1.0, static_cast<double>(anisotropy_max)));
  const int last = frame.level_count - 1;
  const double lod = std::clamp(std::log2(longer / count) + bias, 0.0, static_cast<double>(last));
  PixelTaps taps;
  taps.levels[0] = static_cast<int>(lod);
  taps.levels[1] = std::min(taps.levels[0] + 1, last);
  taps.coarser_share = lod - taps.levels[0];
  const glm::dvec2 axis = length_x > length_y ? along_x : along_y;
  for (int i = 0; i < count; ++i) taps.places.push_back(place + ((i + 0.5) / count - 0.5) * axis);
  return taps;
}

}  // namespace multum
