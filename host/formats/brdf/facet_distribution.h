// SPDX-License-Identifier: Apache-2.0
// The facet distribution f of a BRDF in double precision, and what representations of normals take of it.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

/// What is grey of a colour here.
inline double mean_channel(const glm::dvec3& channels) { return (channels.x + channels.y + channels.z) / 3.0; }

/// f per solid angle, of e = 1 - n.h, 0..2, which narrow f need: n.h would round.
glm::dvec3 facet_density(const Brdf& brdf, double e);

/// The exponent of the Blinn-Phong that is as wide: 1 / it is the variance of slopes along each axis.
double equivalent_exponent(const Brdf& brdf);

/// The integral of f over the sphere, 1 where it is normalised so: not of GGX, whose projection is, nor of
/// measurements.
glm::dvec3 facet_total(const Brdf& brdf);

/// a_l = integral over the sphere of f(t) P_l(t), l = 0 .. `order`: 1, then less, for a normalised density. A
/// convolution by f multiplies the coefficients (l, m) of a function on the sphere by a_l (Han et al. 2007, eq. 7).
std::vector<glm::dvec3> zonal_coefficients(const Brdf& brdf, int order);

/// The integral over the sphere of what is given as a function of 1 - cosine.
glm::dvec3 integrate_zonal(const std::function<glm::dvec3(double)>& f);

}  // namespace multum
