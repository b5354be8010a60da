// SPDX-License-Identifier: Apache-2.0
// The surface between texels. Renderers interpolate a magnified normal map, so a distant pixel shows the interpolated
// surface. The normals of the interpolated surface have a smaller variance than the normals of the texels. For white
// noise, the variance is (2/3)^2 times as large. A bake of the surface uses one of its points for each texel, 0.2113
// texels from the centre of the texel along x and along y. These are the points of the two-point Gauss rule between
// centres (Abramowitz and Stegun 25.4.30), which is exact for polynomials up to degree 3. Therefore the means and
// variances of the interpolated surface are exact, and the bake takes no longer than a bake of the texels. The signs of
// x and y select one of four points:
//
//   texels of one of level 1     (+, s)  (-, -s)     s alternates between 1 and -1 along x
//                                (-, s)  (+, -s)
//
// Each of the four points occurs once. Points are distributed along x and y like texel centres. Between any two columns
// or rows of texels, there are equally many points, so edges along the axes have the right width.
#pragma once

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/wrap_mode.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

inline const char* map_surface_name(MapSurface surface) { return choice_name(kMapSurfaces, surface); }

/// The continuation of values beyond the border. Black and mirrored borders repeat the texels of the border itself.
struct MapWrap {
  WrapMode s = WrapMode::kPeriodic, t = WrapMode::kPeriodic;
};

/// Returns the normals of the points, in new planes according to `spill`. Each normal is the weighted mean of four
/// texels, scaled to the weighted mean of their lengths. The mean of the lengths is 1 without a roughness map, and at
/// most 1 with a roughness map. If the four texels cancel out, the nearest texel gives the direction.
PlaneStore surface_normals(const PlaneStore& texels, const MapWrap& wrap, const SpillPolicy& spill, int threads,
                           Progress* progress);

/// Returns the colours or weights of the same points, interpolated without scaling.
PlaneStore surface_values(const PlaneStore& texels, const MapWrap& wrap, const SpillPolicy& spill, int threads,
                          Progress* progress);

}  // namespace multum
