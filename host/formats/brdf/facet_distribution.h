// SPDX-License-Identifier: Apache-2.0
// The facet distribution f of a BRDF in double precision, and quantities that representations of normals derive from
// it.
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

/// Returns the mean of the channels.
inline double mean_channel(const glm::dvec3& channels) { return (channels.x + channels.y + channels.z) / 3.0; }

/// Returns f per solid angle. The argument is e = 1 - n.h, from 0 to 2, because n.h would lose precision for a narrow
/// f.
glm::dvec3 facet_density(const Brdf& brdf, double e);

/// Returns the exponent of the Blinn-Phong lobe with the same width. The variance of slopes along each axis is 1 /
/// exponent.
double equivalent_exponent(const Brdf& brdf);

/// Returns the integral of f over the sphere. It is 1 for normalized densities, but not for GGX (normalized by
/// projected area) or for measurements.
glm::dvec3 facet_total(const Brdf& brdf);

/// Returns a_l = integral over the sphere of f(t) P_l(t), for l = 0 .. `order`. For a normalized density, a_0 is 1 and
/// the other values are smaller. Convolution with f multiplies the coefficients (l, m) of a function on the sphere by
/// a_l (Han et al. 2007, eq. 7).
std::vector<glm::dvec3> zonal_coefficients(const Brdf& brdf, int order);

/// Returns the integral of a function of e = 1 - cosine over the sphere.
glm::dvec3 integrate_zonal(const std::function<glm::dvec3(double)>& f);

}  // namespace multum
