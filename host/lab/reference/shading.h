// SPDX-License-Identifier: Apache-2.0
// Shades a von Mises-Fisher lobe in double precision, in the simplest form. No bake uses it.
#pragma once

#include <functional>

#include <glm/vec3.hpp>

namespace multum::reference {

/// These functions compute 1 - A(kappa), where A is coth kappa - 1/kappa, and its inverse by bisection.
double vmf_spread(double kappa);
double vmf_kappa(double spread);

/// Returns the integral over the sphere of a vMF's density times P_l.
double zonal_of_vmf(double kappa, int l);

/// Returns the vMF density per solid angle at the angle `theta` (radians) from its mean.
double vmf_density(double kappa, double theta);
/// Returns (s + 1) / (2 pi) max(cos theta, 0)^s.
double blinn_phong(double s, double theta);

/// Returns the spherical convolution of any f(angle in radians) with a vMF. f is 0 below the horizon, and changes
/// mostly within the angle `narrow`.
double convolved(const std::function<double(double)>& f, double narrow, double kappa, double theta);
/// Returns the spherical convolution integral f(n . w) vMF(n; mu, kappa) dn by quadrature, where theta is the angle
/// between w and mu.
double convolved_blinn_phong(double s, double kappa, double theta);
double convolved_lambert(double kappa, double theta);
/// Returns convolved() for max(cos, 0). Above kappa = 1e4, quadrature would need too many points, so the lobe is
/// treated as a normal distribution.
double mean_cosine(double kappa, double theta);
double convolved_vmf(double kappa_f, double kappa, double theta);

/// The highlight of normals with a vMF distribution. With the cosine, it is the integral of f(angle of n and h) vMF(n;
/// mu, kappa) max(n . l, 0) dn. Without the cosine, the last factor is omitted. f is 0 or small where a vMF around h
/// with concentration `facet_kappa` is small.
struct Highlight {
  double with_cosine, without_cosine;
};
Highlight highlight(const std::function<double(double)>& f, double facet_kappa, double kappa, const glm::dvec3& mu,
                    const glm::dvec3& h, const glm::dvec3& l);

/// GGX, and the visibilities V = G / (4 n.l n.v) that glTF uses with GGX and that Cook and Torrance 1982 define.
double ggx(double alpha, double theta);
double convolved_ggx(double alpha, double kappa, double theta);
double smith_visibility(double alpha, double n_l, double n_v);
double groove_visibility(double n_l, double n_v, double n_h, double v_h);
double schlick(double f0, double v_h);

/// Computes the formula of runtime_gl/shaders/common/movmf_shading.glsl, without the amplitude. `spread` is 1 - |r|.
double product_blinn_phong(double s, double spread, double theta);

}  // namespace multum::reference
