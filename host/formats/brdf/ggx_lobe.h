// SPDX-License-Identifier: Apache-2.0
// GGX's facets over a vMF lobe of normals, their spherical convolution, as one term of four numbers from a small table:
//
//   D(e) = P / (pi s^2) S(t) (1 + y (1 + delta y))^-gamma,   e = 1 - mu.h, t = mu.h
//
//   s^2 = alpha^2 + 2 d          how broad both are together; d = 1 - |r| the lobe's spread
//   y = B e (1 - c e) / s^2      c = alpha^2 / (2 s^2): with P = gamma = 1, B = 4 (1 - alpha^2), delta = 1/4 and a lobe
//                                of no width this is GGX (Walter et al. 2007, eq. 33)
//   S(t)                         facets end at the horizon, and a lobe blurs that: smoothstep(-w, w, t),
//                                w^2 = 4.5 d / (1.001 - d), d / (1 - d) near 1 / kappa
//
// P, B, delta and gamma depend smoothly on alpha / s, which is 1 for a single normal and 0 for a mirror of a surface,
// and on s, which says how near the horizon is. They are fitted to quadrature once, when the project is built
// (ggx_lobe_fit); what they are off by is bounded by tests/gl/ggx_lobe_test. The form is ours.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

struct GgxLobeShape {
  double peak = 1.0;   // P
  double slope = 4.0;  // B
  double bend = 0.25;  // delta
  double power = 1.0;  // gamma
};

/// 1 / kappa of a lobe of spread `d`, 0..1, nearly, as shaders have it: multum_vmf_scatter() of ggx_lobe.glsl.
double vmf_scatter(double d);

/// D per solid angle. `alpha`: 0..1, roughness^2. `spread`: d, 0..1. `e`: 0..2.
double ggx_lobe_density(const GgxLobeShape& shape, double alpha, double spread, double e);

/// Where the shape lies in the table: columns by alpha / s, rows by s / sqrt(3), both 0..1, at texels' middles.
constexpr int kGgxLobeTableSide = 32;

/// Halves, [row][column][4]: P / pi, B, delta, -gamma. A texture of it is filtered linearly and clamped.
std::span<const std::uint16_t> ggx_lobe_table();

/// What a linear filter finds in the table.
GgxLobeShape ggx_lobe_shape(double alpha, double spread);

}  // namespace multum
