// SPDX-License-Identifier: Apache-2.0
#include "host/formats/image/normals/flat_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "host/foundation/base/size_of.h"

namespace multum {

Flatness flatness_of(const PlaneStore& normals) {
  constexpr float kStep = 2.02f / 255.0f;  // step of an 8-bit component, with a small margin
  const std::size_t width = size_of(normals.width());
  std::array<std::vector<float>, 3> rows{std::vector<float>(width), std::vector<float>(width),
                                         std::vector<float>(width)};
  std::array<float, 2> low{2.0f, 2.0f}, high{-2.0f, -2.0f};
  for (int row = 0; row < normals.height(); ++row) {
    normals.read_rows(row, 1, {rows[0].data(), rows[1].data(), rows[2].data()});
    for (std::size_t k = 0; k < low.size(); ++k) {
      const auto [least, most] = std::minmax_element(rows[k].begin(), rows[k].end());
      low[k] = std::min(low[k], *least), high[k] = std::max(high[k], *most);
      if (high[k] - low[k] > kStep) return Flatness::kRelief;
    }
  }
  const float x = 0.5f * (low[0] + high[0]), y = 0.5f * (low[1] + high[1]);
  return std::hypot(x, y) < kStep ? Flatness::kFlat : Flatness::kOneNormal;
}

std::string flat_note(Flatness flatness) {
  if (flatness == Flatness::kRelief) return "";
  return std::string("its normals are all equal") + (flatness == Flatness::kFlat ? ", and flat" : "") +
         ": averages represent them exactly, so lobes and fitted levels bring no benefit";
}

}  // namespace multum
