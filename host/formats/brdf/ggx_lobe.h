// SPDX-License-Identifier: Apache-2.0
// Spherical convolution of the facets of GGX with a vMF lobe of normals. It is one term with four numbers from a small
// table:
//
//   D(e) = P / (pi s^2) S(t) (1 + y (1 + delta y))^-gamma,   e = 1 - mu.h, t = mu.h
//
//   s^2 = alpha^2 + 2 d          combined width; d = 1 - |r| is the lobe's spread
//   y = B e (1 - c e) / s^2      c = alpha^2 / (2 s^2): with P = gamma = 1, B = 4 (1 - alpha^2), delta = 1/4 and a lobe
//                                of zero width this is GGX (Walter et al. 2007, eq. 33)
//   S(t)                         facets end at the horizon, and a lobe blurs the end: smoothstep(-w, w, t),
//                                w^2 = 4.5 d / (1.001 - d), d / (1 - d) near 1 / kappa
//
// P, B, delta and gamma depend smoothly on alpha / s (1 for a single normal, 0 for a mirror) and on s (the distance to
// the horizon). The build fits them to quadrature once (ggx_lobe_fit). tests/gl/ggx_lobe_test bounds the error. This
// form is not from a paper.
#pragma once

#include <cstdint>
#include <span>

namespace multum {

struct GgxLobeShape {
  double peak = 1.0;   // the number P
  double slope = 4.0;  // the number B
  double bend = 0.25;  // the number delta
  double power = 1.0;  // the number gamma
};

/// Returns approximately 1 / kappa of a lobe with spread `d`, 0..1, like multum_vmf_scatter() of ggx_lobe.glsl.
double vmf_scatter(double d);

/// Returns D per solid angle. `alpha` is roughness^2, 0..1. `spread` is d, 0..1. `e` is 0..2.
double ggx_lobe_density(const GgxLobeShape& shape, double alpha, double spread, double e);

/// The columns of the table are values of alpha / s, and its rows are values of s / sqrt(3). Both are 0..1, at texel
/// centres.
constexpr int kGgxLobeTableSide = 32;

/// Returns half floats [row][column][4]: P / pi, B, delta, -gamma, for a texture with linear filtering and clamping.
std::span<const std::uint16_t> ggx_lobe_table();

/// Looks up the shape in the table as a linear filter does.
GgxLobeShape ggx_lobe_shape(double alpha, double spread);

}  // namespace multum
