// SPDX-License-Identifier: Apache-2.0
// Shades and samples a mixture of von Mises-Fisher lobes on the processor, in double precision. The formulas are those
// of the GL runtime (runtime_gl/shaders/common/movmf_shading.glsl, brdf/terms.glsl and surface/movmf.glsl). The facets
// of a BRDF are a sum of vMFs, and mean cosines multiply under convolution (Han et al. 2007, sections 4 and 7).
//
// Sampling follows Walter et al. 2007, section 5.3. A half vector h is drawn from the convolved lobes, and the view
// direction is reflected by it. The density of l is therefore the density of h over 4 |v.h|. The diffuse part is
// sampled by the cosine around the mean direction of each lobe. All techniques are mixed in one density.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "host/api/multum.h"
#include "host/formats/brdf/brdf.h"
#include "host/formats/brdf/vmf_terms.h"

struct multum_brdf {
  multum::Brdf brdf;
  std::vector<multum::VmfTerm> terms;  // empty if there is no highlight
  double exponent = 0.0;               // Blinn-Phong exponent of about the same width, for the visibility term
};

namespace multum {

/// Returns a BRDF with its terms. Throws Error(kUsage) and Error(kInput) like parse_brdf().
multum_brdf shaded_brdf(const std::string& text);

/// Implements multum_shade().
glm::dvec3 shade_lobes(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& l, const glm::dvec3& v);

/// Implements multum_density().
double lobe_density(const multum_lobes& lobes, const glm::dvec3& n);

/// Implement multum_sample() and multum_pdf().
double sample_lobes(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& v, const glm::dvec3& random,
                    glm::dvec3& l);
double lobe_pdf(const multum_lobes& lobes, const multum_brdf& brdf, const glm::dvec3& v, const glm::dvec3& l);

}  // namespace multum
