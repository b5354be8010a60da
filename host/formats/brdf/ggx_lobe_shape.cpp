// SPDX-License-Identifier: Apache-2.0
// Looks up shapes in the embedded table. This code is separate from ggx_lobe.cpp, which is linked into the program that
// makes the table.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/formats/brdf/ggx_lobe.h"
#include "host/foundation/base/half_bits.h"

namespace multum {

GgxLobeShape ggx_lobe_shape(double alpha, double spread) {
  constexpr double kLast = kGgxLobeTableSide - 1;
  const std::span<const std::uint16_t> table = ggx_lobe_table();
  const double s = std::sqrt(alpha * alpha + 2.0 * spread);
  const double x = std::clamp(alpha / std::max(s, 1e-12), 0.0, 1.0) * kLast;
  const double y = std::clamp(s / std::numbers::sqrt3, 0.0, 1.0) * kLast;
  const auto column = static_cast<std::size_t>(std::min(x, kLast - 1.0));
  const auto row = static_cast<std::size_t>(std::min(y, kLast - 1.0));
  std::array<double, 4> mixed{};
  for (std::size_t j = 0; j < 2; ++j)
    for (std::size_t i = 0; i < 2; ++i) {
      const double along = x - static_cast<double>(column), down = y - static_cast<double>(row);
      const double weight = (i == 0 ? 1.0 - along : along) * (j == 0 ? 1.0 - down : down);
      for (std::size_t k = 0; k < 4; ++k)
        mixed[k] +=
            weight * static_cast<double>(half_to_float(table[((row + j) * kGgxLobeTableSide + column + i) * 4 + k]));
    }
  return {std::numbers::pi * mixed[0], mixed[1], mixed[2], -mixed[3]};
}

}  // namespace multum
