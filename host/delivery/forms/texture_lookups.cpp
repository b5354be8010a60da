// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/texture_lookups.h"

#include <algorithm>
#include <glm/geometric.hpp>

namespace multum {

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
