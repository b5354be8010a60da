// SPDX-License-Identifier: Apache-2.0
// Fits mixtures of planar Gaussians in double precision, in the simplest form, as the reference for the EM kernels that
// are built with MULTUM_PLANAR and for their shading. The code follows Tan et al. 2005, sections 3 and 4.1, with the
// corrections in docs/contributing/ALGORITHMS.md. No bake uses it.
//
// The types are the types of movmf_em.h, with other coordinates. A sample is (n_x, n_y, scatter). A lobe's mu is (x, y,
// 0), and its kappa is 1/sigma^2. Moments are r = (mean x, mean y, sigma^2). A prior is C sum_k a_k (x, y, 1).
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/lab/reference/movmf_em.h"

namespace multum::reference {

/// Returns the sample of a finest normal. If the normal was shortened to c n to represent the width of a BRDF, its
/// scatter is 2 v, but at most 1 - |p|^2. Here v = (1 - c) / (2 - c) (1 - |p|^2 / 2).
glm::dvec3 planar_sample(const glm::dvec3& normal, bool shortened);

/// Runs EM and returns the moments of the last E-step. Stores the parameters of this E-step in `lobes`.
std::vector<Moments> fit_planar(const std::vector<Sample>& samples, std::vector<Lobe>& lobes, const EmOptions& options);

/// Returns the sigma^2 of facets whose distribution is normalised Blinn-Phong with exponent s. The facets surround a
/// normal whose projection has the squared length `mean_square`.
double facet_variance(double s, double mean_square);

/// Returns the density per solid angle, at the unit vector h, of a filtered lobe (a mu, a (2 sigma^2 + |mu|^2), a). The
/// facets of the lobe have the sigma^2 of facet_variance().
double gmm_density(const glm::dvec4& lobe, double s, const glm::dvec3& h);
/// Returns `a * max(mu . l, 0)`, where mu is the mean, projected up onto the sphere.
double gmm_lambert(const glm::dvec4& lobe, const glm::dvec3& light);

}  // namespace multum::reference
