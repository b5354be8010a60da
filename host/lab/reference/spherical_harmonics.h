// SPDX-License-Identifier: Apache-2.0
// Computes spherical harmonics directly from their definition, in double precision, to test kernels/sh_project.cl,
// kernels/sh_shade.cl and sh_shading.glsl.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

namespace multum::reference {

/// Returns the real Y_lm of a direction of any length, from Legendre functions of its angles, without the
/// Condon-Shortley phase.
double sh_basis(int l, int m, const glm::dvec3& n);

/// Returns all Y_lm from l = 1 to `order`. Y_lm has the index l*l + l + m - 1.
std::vector<double> sh_basis_to(int order, const glm::dvec3& n);

/// Returns 2 pi integral f(t) P_l(t) dt by quadrature, for l from 0 to `order`. f may be discontinuous only at t = 0.
std::vector<double> zonal_by_quadrature(int order, const std::function<double(double)>& f);

/// Returns the sum of a_l g_lm Y_lm(w) without clamping. `share` is the factor of Y_00.
double shade_sh(const std::vector<double>& coefficients, double share, const std::vector<double>& zonal,
                const glm::dvec3& w);

}  // namespace multum::reference
