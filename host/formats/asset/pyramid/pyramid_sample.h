// SPDX-License-Identifier: Apache-2.0
// Pyramidal parametric sampling (Williams 1983, sections 2 and 3): bilinear within a level, linear between two, at any
// real level d; and the choice of d. In double: what the GL's filter is held to, and what makes meshes of a chosen
// level of detail.
#pragma once

#include <array>

#include "host/formats/asset/pyramid/pyramid_file.h"

namespace multum {

using PyramidSample = std::array<double, 3>;  // one channel: the first

/// At s, t (0..1 across the map, t downwards; beyond: as the header's wrap modes say), level `d`, held to those there
/// are.
PyramidSample sample_pyramid(const Pyramid& pyramid, double s, double t, double d);

/// One level of it, bilinear.
PyramidSample sample_level(const Pyramid& pyramid, int level, double s, double t);

/// Growth of texture coordinates, in texels of level 0, from one pixel to the next.
struct TexelDerivatives {
  double u_x, v_x;  // along a row of pixels
  double u_y, v_y;  // down a column
};

/// Heckbert's choice (Williams 1983, section 3): d = log2 max(|(u_x, v_x)|, |(u_y, v_y)|), the wider side of the
/// pixel's parallelogram: blurred rather than aliased. Minus infinity where nothing changes.
double mip_level_of(const TexelDerivatives& derivatives);

}  // namespace multum
