// SPDX-License-Identifier: Apache-2.0
// Refines lobes in double, written for obviousness: the oracle of kernels/movmf_refine.cl, which says what is minimised
// and how. No bake uses it.
#pragma once

#include <vector>

#include "host/lab/reference/movmf_em.h"

namespace multum::reference {

/// A lobe as bakes store it.
struct MeanLobe {
  glm::dvec3 r;
  double amplitude;
};

struct RefinedTexel {
  std::vector<Sample> samples;
  std::vector<MeanLobe> lobes;                // as EM left them
  std::vector<std::vector<MeanLobe>> beside;  // those of the up to four texels beside, as many each
};

/// Runs `steps` steps on the lobes of a texel and returns them.
std::vector<MeanLobe> refine(const RefinedTexel& texel, int steps);

/// What is minimised, at some lobes of the texel, without squares that no lobe changes.
double refined_energy(const RefinedTexel& texel, const std::vector<MeanLobe>& lobes);

/// By what the refined lobes and EM's are compared: the sum over the highlights of their relative L1 errors, >= 0, over
/// the half vectors of kernels/shared/movmf_refine.h.
double seen_error(const RefinedTexel& texel, const std::vector<MeanLobe>& lobes);

}  // namespace multum::reference
