// SPDX-License-Identifier: Apache-2.0
// The project's own test map: four quarters that each defeat one shortcut. Made from a seed, at any even size, so that
// every figure in docs/evidence/ACCURACY.md can be made again anywhere.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/formats/image/normals/normal_map.h"
#include "host/foundation/base/choices.h"

namespace multum {

struct FourQuarterMap {
  NormalMap normals;  // rounded to 16 bits as the PNG stores them, then normalised
  ColourMap albedo;   // colours correlated with slope
};

enum class Quarter { kArmour, kRings, kGrooves, kNoise };
inline constexpr Choices<Quarter> kQuarters = {{"armour", Quarter::kArmour},
                                               {"rings", Quarter::kRings},
                                               {"grooves", Quarter::kGrooves},
                                               {"noise", Quarter::kNoise}};

/// `size` >= 16, even. Top left: armour of overlapping hemispherical scales (period 24 texels); top right: carved rings
/// (wavelength 16, 55 % cut); bottom left: V-grooves (period 12, rotated 30 degrees, slopes +-1, 20 % flat) with red
/// and blue facets; bottom right: fine noise whose slope grows to the right (rms 0.45 on average).
/// With `alone`, that quarter alone fills the map.
FourQuarterMap make_four_quarter_map(int size, std::uint64_t seed, std::optional<Quarter> alone = std::nullopt);

/// Writes PREFIX_normal.png (16 bits, n / 2 + 1/2) and PREFIX_albedo.png (16 bits, sRGB) of the same map, atomically
/// and by rows: it need not fit into memory. To read back the same normals, say green up: its statistics say green down
/// (see four_quarter_map.cpp). Throws Error(kEnvironment).
void write_four_quarter_map(int size, std::uint64_t seed, const std::string& prefix,
                            std::optional<Quarter> alone = std::nullopt);

}  // namespace multum
