// SPDX-License-Identifier: Apache-2.0
// Fits a facet distribution by a short sum of von Mises-Fisher densities around h: each is convolved with a vMF lobe by
// multiplying mean cosines (Han et al. 2007, section 4; docs/contributing/ALGORITHMS.md, "BRDFs at run time").
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

struct VmfTerm {
  glm::dvec3 weight;  // its integral over the sphere, a channel each
  double kappa;
  double spread;  // 1 - A(kappa), A = coth kappa - 1/kappa
};

/// 1 - A(kappa) without cancellation.
double vmf_spread(double kappa);
/// Its inverse, by bisection in the logarithm: 1e-6..1e9.
double vmf_kappa(double spread);

/// Weights may be negative, where f ends at the horizon or rises towards it; the sum may then be, by a little, and is
/// taken for 0. `density`: f of e = 1 - n.h in 0..1, finite and >= 0; beyond, where facets face away, it counts as 0.
/// `count`: 1..kBrdfTermCountMax. All channels share the kappas. Deterministic; a few milliseconds.
std::vector<VmfTerm> fit_vmf_terms(const std::function<glm::dvec3(double)>& density, int count);

/// Of a BRDF: the one term that it is, where it is one or is near one (Blinn-Phong: equal mean cosine), else a fit by
/// `brdf.term_count` terms.
std::vector<VmfTerm> vmf_terms(const Brdf& brdf);

}  // namespace multum
