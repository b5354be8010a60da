// SPDX-License-Identifier: Apache-2.0
// Pyramidal parametric sampling (Williams 1983, sections 2 and 3). It is bilinear within a level, and linear between
// two levels, at any real level d. Also chooses d. Computes in double precision. Serves as the reference for the filter
// of GL, and as the sampler for meshes at a chosen level of detail.
#pragma once

#include <array>

#include "host/formats/asset/pyramid/pyramid_file.h"

namespace multum {

using PyramidSample = std::array<double, 3>;  // if there is one channel, only the first value is used

/// Samples at s and t, which are 0..1 across the map; t grows downwards. Outside the map, the wrap modes of the header
/// apply. `d` is clamped to the existing levels.
PyramidSample sample_pyramid(const Pyramid& pyramid, double s, double t, double d);

/// Samples one level bilinearly.
PyramidSample sample_level(const Pyramid& pyramid, int level, double s, double t);

/// The change of the texture coordinates from one pixel to the next, in texels of level 0.
struct TexelDerivatives {
  double u_x, v_x;  // along a row of pixels
  double u_y, v_y;  // down a column of pixels
};

/// Returns the level by Heckbert's rule (Williams 1983, section 3): d = log2 max(|(u_x, v_x)|, |(u_y, v_y)|). The
/// longer side of the pixel's parallelogram determines the level, so that textures blur instead of aliasing. Returns
/// minus infinity if nothing changes.
double mip_level_of(const TexelDerivatives& derivatives);

}  // namespace multum
