// SPDX-License-Identifier: Apache-2.0
// Chooses the footprints whose errors are measured: what pixels of pictures cover of a map, spread evenly over octaves
// of size, over directions and elongations, anywhere on the map. Says which texels the runtime's filter reads for each
// (host/formats/asset/tap_filter.h).
//
//         ______             a footprint is a rectangle in texels of level 0: the pixel's square, as it lies on a
//        /     /  b          plane that is looked at from anywhere. Its shorter side b, 2^u texels, says how far away
//       /  x  /              the surface is; the longer, a = e b, how much it is tilted; x is one of N taps, here 2.
//      /  x  /
//     /_____/ a
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>

#include "host/bakes/accuracy/point_taps.h"
#include "host/bakes/accuracy/texel_selection.h"
#include "host/formats/asset/tap_filter.h"
#include "host/foundation/base/wrap_mode.h"

namespace multum {

struct Footprint {
  int octave;              // floor(u)
  glm::dvec2 centre;       // texels of level 0, in the map
  glm::dvec2 longer_side;  // the vector along it
  glm::dvec2 shorter_side;
};

struct FootprintSettings {
  int per_octave = 256;  // 0: none
  int first_octave = 0;  // smaller footprints are not measured
  std::uint64_t seed = 1;
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // what lies beyond the map's borders
  TapFilter filter = {};
  double elongation_max = 4.0;  // the longest footprint's longer side over its shorter
};

/// Octaves of a map: from 1 texel to the longer side, at least one.
int footprint_octave_count(int map_width, int map_height);

/// settings.per_octave of each octave, one octave after the other. Their centres are one at random in each of as many
/// cells of equal area, about square; u and log2 e are one at random in each of as many equal intervals, in random
/// order; e is from 1 to settings.elongation_max.
std::vector<Footprint> choose_footprints(int map_width, int map_height, const FootprintSettings& settings);

/// A texel that a filter reads.
struct FilterTap {
  int point;  // what is shaded by itself: 0 to the footprint's point count - 1
  int level, texel;
  double weight;
};
/// What the filter reads for a footprint, appended, and how many points it shades there; a footprint's value is their
/// mean. The weights of a point sum to 1, less where a black border lies under it.
int append_filter_taps(const Footprint& footprint, const std::vector<PlaneSize>& levels,
                       const FootprintSettings& settings, std::vector<FilterTap>& taps);

/// Index i, of any value, of `count` texels; -1: beyond a black border.
int wrapped_index(std::int64_t i, int count, WrapMode mode);

}  // namespace multum
