// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics Y_lm up to a given order, as kernels and shaders compute them, and the coefficients of
// BRDFs of one angle (Han et al. 2007, sections 4 and 5).
//
// Convention: Y_1,-1, Y_10, Y_11 are y, z, x times sqrt(3 / 4 pi), without the Condon-Shortley phase. For unit (x, y,
// z):
//
//     Y_lm = p_lm(z) Re (x + iy)^m,  Y_l,-m = p_lm(z) Im (x + iy)^m     m >= 0
//     p_mm constant,  p_lm = a_lm z p_l-1,m - b_lm p_l-2,m
//
// The p_lm are normalized in each step, so that nothing overflows. The factor sin^m is part of (x + iy)^m, so that
// poles need no special case. In single precision, Y is within 4e-6 of its bound sqrt((2l+1)/4pi) up to order 20
// (tests/kernels).
#pragma once

#include <vector>

namespace multum {

/// The lowest order. A file of a given order stores all bands l from 1 to this order; order 0 would store no
/// coefficients.
constexpr int kShOrderMin = 1;
constexpr int kShOrderMax = 20;

/// The number of stored coefficients, which begin at l = 1. The coefficient of l = 0 is 1/sqrt(4 pi) for all normals.
constexpr int sh_coefficient_count(int order) { return order * (order + 2); }
/// The index of the coefficient of (l, m). The list for a higher order starts with the coefficients of a lower order.
constexpr int sh_coefficient(int l, int m) { return l * l + l + m - 1; }
/// The number of parts, which have four coefficients each. For even orders, all parts are full.
constexpr int sh_part_count(int order) { return (sh_coefficient_count(order) + 3) / 4; }

/// The value of Y_00.
constexpr double kShConstant = 0.28209479177387814;
/// Y_1,-1, Y_10 and Y_11 of a unit normal are y, z and x times this factor.
constexpr float kShNormalFactor = 0.48860251f;

/// The constants of the recurrence, in order of use. For each m from 0, (p_mm, 0) comes first, followed by (a_lm, b_lm)
/// for l from m + 1 to `order`.
struct ShStep {
  float a, b;
};
std::vector<ShStep> sh_recurrence(int order);
constexpr int sh_step_count(int order) { return (order + 1) * (order + 2) / 2; }

/// The zonal coefficients of a function f of the cosine t: [l] = 2 pi integral f(t) P_l(t) dt, for l from 0 to `order`.
/// Convolution with f multiplies band l by coefficient l.
using ZonalCoefficients = std::vector<double>;

/// Returns the exact coefficients of (s + 1)/(2 pi) max(t, 0)^s: a_0 = 1, a_1 = (s + 1)/(s + 2), a_l = a_l-2 (s - l +
/// 2)/(s + l + 1).
ZonalCoefficients zonal_blinn_phong(int order, double s);
/// Returns the exact coefficients of max(t, 0), which are pi, 2 pi/3, pi/4, 0, -pi/24, 0, ...
ZonalCoefficients zonal_lambert(int order);
/// Returns the coefficients 1, c, ... of the von Mises-Fisher distribution with mean cosine c, 0 < c <= 1. All
/// coefficients are 1 at c = 1. If the width of a BRDF is included, the bands of a normal of level 0 are multiplied by
/// these coefficients (kernels/device/vmf_zonal.clh).
ZonalCoefficients zonal_vmf(int order, double mean_cosine);
/// Returns coefficients of max(t, 0) for files that include the width of a BRDF, which weakens the bands of normals
/// (zonal_vmf()). The coefficients are divided by the vMF coefficients of the map's mean cosine
/// (BakedHeader::mean_cosine). The divisors are at least 0.1, because weaker bands contain mostly rounding errors.
ZonalCoefficients zonal_lambert_of_rough(int order, double mean_cosine);

}  // namespace multum
