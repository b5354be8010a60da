// SPDX-License-Identifier: Apache-2.0
// The surface between texels. Renderers interpolate a normal map where it is magnified, so what lies behind a distant
// pixel is that surface, whose normals spread less than the texels' own: of white noise, (2/3)^2 of the variance. A
// bake of it takes in each texel's place one point of the surface, 0.2113 texels beside the texel's middle along x and
// along y: those are the points of the two-point Gauss rule between middles (Abramowitz and Stegun 25.4.30), exact for
// polynomials of degree 3, so that means and variances of what is interpolated are its own at the cost of a bake of the
// texels. Which of the four, by signs of x and y:
//
//   texels of one of level 1     (+, s)  (-, -s)     s = 1 and -1 by turns along x
//                                (-, s)  (+, -s)
//
// All four are there once; points are spread along x and y as middles are; and between any two columns of texels, or
// rows, lie as many as between others, so that edges along the axes are as wide as they should be.
#pragma once

#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/base/wrap_mode.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

inline const char* map_surface_name(MapSurface surface) { return choice_name(kMapSurfaces, surface); }

/// How values beyond the border continue. Black and mirrored borders have the border's own texels there.
struct MapWrap {
  WrapMode s = WrapMode::kPeriodic, t = WrapMode::kPeriodic;
};

/// The points' normals, in new planes where `spill` says: the four around, weighted, the sum made as long as their
/// lengths, weighted: 1, or what a roughness map left of it. Four that cancel have the nearest one's direction.
PlaneStore surface_normals(const PlaneStore& texels, const MapWrap& wrap, const SpillPolicy& spill, int threads,
                           Progress* progress);

/// The same points' colours or weights: interpolated as they are.
PlaneStore surface_values(const PlaneStore& texels, const MapWrap& wrap, const SpillPolicy& spill, int threads,
                          Progress* progress);

}  // namespace multum
