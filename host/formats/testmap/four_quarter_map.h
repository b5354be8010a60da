// SPDX-License-Identifier: Apache-2.0
// The test map of this project. It has four quarters, and a different simplification fails in each of them. A seed and
// an even size reproduce the map, so every figure in docs/evidence/ACCURACY.md can be reproduced anywhere.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/formats/image/normals/normal_map.h"
#include "host/foundation/base/choices.h"

namespace multum {

struct FourQuarterMap {
  NormalMap normals;  // normals rounded to 16 bits as in the PNG, then normalised
  ColourMap albedo;   // colours correlated with slope
};

enum class Quarter { kArmour, kRings, kGrooves, kNoise };
inline constexpr Choices<Quarter> kQuarters = {{"armour", Quarter::kArmour},
                                               {"rings", Quarter::kRings},
                                               {"grooves", Quarter::kGrooves},
                                               {"noise", Quarter::kNoise}};

/// `size` is even and at least 16. The top left quarter is armour of overlapping hemispherical scales (period 24
/// texels). The top right quarter has carved rings (wavelength 16, 55 % cut). The bottom left quarter has V-grooves
/// (period 12, rotated 30 degrees, slopes +-1, 20 % flat) with red and blue facets. The bottom right quarter is fine
/// noise whose slope grows to the right (rms 0.45 on average). If `alone` is set, that quarter fills the whole map.
FourQuarterMap make_four_quarter_map(int size, std::uint64_t seed, std::optional<Quarter> alone = std::nullopt);

/// Writes PREFIX_normal.png (16 bits, n / 2 + 1/2) and PREFIX_albedo.png (16 bits, sRGB) of the same map. Writes both
/// files atomically and row by row, so the map does not have to fit into memory. By default, green points down
/// (four_quarter_map.cpp gives the reason). If PREFIX_normal.png is read with green up, its normals are those of
/// make_four_quarter_map(). kUp flips green, as glTF requires. Throws Error(kEnvironment).
void write_four_quarter_map(int size, std::uint64_t seed, const std::string& prefix,
                            std::optional<Quarter> alone = std::nullopt, GreenAxis green = GreenAxis::kDown);

}  // namespace multum
