// SPDX-License-Identifier: Apache-2.0
// Real spherical harmonics Y_lm up to a given order, as kernels and shaders compute them, and what a BRDF of one angle
// becomes in them (Han et al. 2007, sections 4 and 5).
//
// Convention: Y_1,-1, Y_10, Y_11 go with y, z, x, all with a factor of sqrt(3 / 4 pi); no Condon-Shortley phase. For
// unit (x, y, z):
//
//     Y_lm = p_lm(z) Re (x + iy)^m,  Y_l,-m = p_lm(z) Im (x + iy)^m     m >= 0
//     p_mm constant,  p_lm = a_lm z p_l-1,m - b_lm p_l-2,m
//
// normalised on the way, so that nothing overflows, and with sin^m taken into (x + iy)^m, so that a pole is a point as
// any other. In single precision Y is within 4e-6 of its bound sqrt((2l+1)/4pi) up to order 20 (tests/kernels).
#pragma once

#include <vector>

namespace multum {

/// Orders: all l from 0 to this one. Of order 0 there is nothing to store.
constexpr int kShOrderMin = 1;
constexpr int kShOrderMax = 20;

/// Coefficients that are stored: l from 1. The one of l = 0 is 1/sqrt(4 pi), whatever the normals.
constexpr int sh_coefficient_count(int order) { return order * (order + 2); }
/// Index of the coefficient of (l, m). An order's coefficients are the first of a higher order's.
constexpr int sh_coefficient(int l, int m) { return l * l + l + m - 1; }
/// Parts of four coefficients; of even orders all are full.
constexpr int sh_part_count(int order) { return (sh_coefficient_count(order) + 3) / 4; }

/// Y_00.
constexpr double kShConstant = 0.28209479177387814;
/// Y_1,-1, Y_10, Y_11 of a unit normal are y, z, x times this.
constexpr float kShNormalFactor = 0.48860251f;

/// The recurrence's constants in the order in which it takes them: for each m from 0 first (p_mm, 0), then (a_lm, b_lm)
/// of l = m + 1 to `order`.
struct ShStep {
  float a, b;
};
std::vector<ShStep> sh_recurrence(int order);
constexpr int sh_step_count(int order) { return (order + 1) * (order + 2) / 2; }

/// Zonal coefficients of a function f of the cosine t, [l] = 2 pi integral f(t) P_l(t) dt: convolving multiplies band l
/// by them. With l from 0 to `order`.
using ZonalCoefficients = std::vector<double>;

/// (s + 1)/(2 pi) max(t, 0)^s, exactly: a_0 = 1, a_1 = (s + 1)/(s + 2), a_l = a_l-2 (s - l + 2)/(s + l + 1).
ZonalCoefficients zonal_blinn_phong(int order, double s);
/// max(t, 0), exactly: pi, 2 pi/3, pi/4, 0, -pi/24, 0, ...
ZonalCoefficients zonal_lambert(int order);
/// The von Mises-Fisher distribution of that mean cosine, 0 < c <= 1: what a BRDF's width makes of a finest normal's
/// bands (kernels/device/vmf_zonal.clh). 1, c, ...; all 1 where c is.
ZonalCoefficients zonal_vmf(int order, double mean_cosine);
/// max(t, 0) of normals whose bands a BRDF's width has weakened as zonal_vmf() does: divided by that, of the mean over
/// the map (BakedHeader::mean_cosine), but nothing by less than 0.1, beyond which there is little but rounding.
ZonalCoefficients zonal_lambert_of_rough(int order, double mean_cosine);

}  // namespace multum
