// SPDX-License-Identifier: Apache-2.0
// Refines lobes in double, written for obviousness: the oracle of kernels/movmf_refine.cl, which says what is minimised
// and how. No bake uses it.
#pragma once

#include <vector>

#include "host/reference/movmf_em.h"

namespace multum::reference {

/// A lobe as bakes store it.
struct MeanLobe {
  glm::dvec3 r;
  double amplitude;
};

/// Runs `steps` steps on the lobes of a texel and returns them.
std::vector<MeanLobe> refine(const std::vector<Sample>& samples, const std::vector<MeanLobe>& lobes, int steps);

/// What is minimised, without the samples' own product, which no lobe changes.
double refined_energy(const std::vector<Sample>& samples, const std::vector<MeanLobe>& lobes);

}  // namespace multum::reference
