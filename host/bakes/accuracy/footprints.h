// SPDX-License-Identifier: Apache-2.0
// Chooses the footprints whose errors are measured. A footprint is the area of a map that a pixel of a picture covers.
// The footprints are spread evenly over sizes (by octaves), directions, elongations and the map. Also lists the texels
// that the runtime's filter reads for each footprint (host/formats/asset/tap_filter.h).
//
//         ______             a footprint is a rectangle in texels of level 0: the pixel's square, projected onto a
//        /     /  b          plane that is seen from any direction. The shorter side b = 2^u texels depends on the
//       /  x  /              distance; the longer side a = e b depends on the tilt; x is one of N taps, here 2.
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
  glm::dvec2 centre;       // position in texels of level 0, inside the map
  glm::dvec2 longer_side;  // vector along the longer side
  glm::dvec2 shorter_side;
};

struct FootprintSettings {
  int per_octave = 256;  // at most; 0 chooses no footprints
  int first_octave = 0;  // smaller footprints are not measured
  std::uint64_t seed = 1;
  WrapMode wrap_s = WrapMode::kPeriodic, wrap_t = WrapMode::kPeriodic;  // apply beyond the map's borders
  TapFilter filter = {};
  double elongation_max = 4.0;  // longer side / shorter side of the longest footprint
};

/// Returns the number of octaves from 1 texel to the longer side of the map, which is at least 1.
int footprint_octave_count(int map_width, int map_height);

/// Returns the number of footprints of an octave. There are at most 16 for each footprint of average size that fits
/// into the map, because more would repeat the same texels, but at least kFootprintsMin and at most `per_octave`.
int footprint_count(int octave, int map_width, int map_height, int per_octave);
constexpr int kFootprintsMin = 32;

/// Returns footprint_count() footprints for each octave, octave by octave. Each centre is a random point in its own
/// cell. The cells have equal areas and are approximately square. Each u and each log2 e is random within its own
/// interval. The intervals have equal lengths and are in random order. The elongation e is from 1 to
/// settings.elongation_max.
std::vector<Footprint> choose_footprints(int map_width, int map_height, const FootprintSettings& settings);

/// A texel that a filter reads.
struct FilterTap {
  int point;  // index of the shaded point: 0 to the footprint's point count - 1
  int level, texel;
  double weight;
};
/// Appends the texels that the filter reads for a footprint. Returns the number of shaded points. The mean of their
/// values is the footprint's value. The weights of a point sum to 1, or to less if part of the point is on a black
/// border.
int append_filter_taps(const Footprint& footprint, const std::vector<PlaneSize>& levels,
                       const FootprintSettings& settings, std::vector<FilterTap>& taps);

/// Wraps any index i to 0..count - 1. Returns -1 beyond a black border.
int wrapped_index(std::int64_t i, int count, WrapMode mode);

}  // namespace multum
