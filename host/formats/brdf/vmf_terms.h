// SPDX-License-Identifier: Apache-2.0
// Fits a facet distribution by a short sum of von Mises-Fisher densities around h. Convolution with a vMF lobe then
// only multiplies mean cosines (Han et al. 2007, section 4; docs/contributing/ALGORITHMS.md, "BRDFs at run time").
#pragma once

#include <functional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"

namespace multum {

struct VmfTerm {
  glm::dvec3 weight;  // integral over the sphere, per channel
  double kappa;
  double spread;  // 1 - A(kappa), A = coth kappa - 1/kappa
};

/// Returns 1 - A(kappa) without cancellation.
double vmf_spread(double kappa);
/// The inverse of vmf_spread(), by bisection of the logarithm of kappa, from 1e-6 to 1e9.
double vmf_kappa(double spread);

/// Fits `count` terms (1..kBrdfTermCountMax). `density` returns f for e = 1 - n.h in 0..1, which must be finite and >=
/// 0. For larger e, facets face away, and f counts as 0. All channels share the kappas. Weights may be negative if f
/// ends at the horizon or rises towards it. The sum may then be slightly negative, which counts as 0. The fit is
/// deterministic and takes a few milliseconds.
std::vector<VmfTerm> fit_vmf_terms(const std::function<glm::dvec3(double)>& density, int count);

/// Returns the terms of a BRDF. Returns one term if the BRDF is a vMF or close to one (for Blinn-Phong, the vMF with
/// the same mean cosine). Otherwise returns a fit with `brdf.term_count` terms.
std::vector<VmfTerm> vmf_terms(const Brdf& brdf);

}  // namespace multum
