// SPDX-License-Identifier: Apache-2.0
// Mixtures of planar Gaussians in double, written for obviousness: the oracle of the EM kernels built with
// MULTUM_PLANAR and of their shading. Tan et al. 2005, sections 3 and 4.1, with the corrections of
// docs/contributing/ALGORITHMS.md. No bake uses it.
//
// Points, means and priors are those of movmf_em.h with other coordinates: of a sample (n_x, n_y, scatter), of a lobe's
// mu (x, y, 0), its kappa 1/sigma^2; of moments r = (mean x, mean y, sigma^2); of a prior C sum_k a_k (x, y, 1).
#pragma once

#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/lab/reference/movmf_em.h"

namespace multum::reference {

/// The sample of a finest normal; of one that a BRDF's width has shortened to c n, scatter is 2 v, v = (1 - c) / (2 -
/// c) (1 - |p|^2 / 2), at most 1 - |p|^2.
glm::dvec3 planar_sample(const glm::dvec3& normal, bool shortened);

/// Runs EM and returns the moments of the last E-step; `lobes` holds that E-step's parameters afterwards.
std::vector<Moments> fit_planar(const std::vector<Sample>& samples, std::vector<Lobe>& lobes, const EmOptions& options);

/// sigma^2 about a normal whose projection has the square `mean_square`, of facets with the distribution of normalised
/// Blinn-Phong of exponent s.
double facet_variance(double s, double mean_square);

/// Density per solid angle of a filtered lobe (a mu, a (2 sigma^2 + |mu|^2), a) with such facets at the unit vector h.
double gmm_density(const glm::dvec4& lobe, double s, const glm::dvec3& h);
/// a max(mu . l, 0), mu lifted to the sphere.
double gmm_lambert(const glm::dvec4& lobe, const glm::dvec3& light);

}  // namespace multum::reference
