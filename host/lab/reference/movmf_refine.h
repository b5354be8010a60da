// SPDX-License-Identifier: Apache-2.0
// Refines lobes in double precision, in the simplest form, as the reference for kernels/movmf_refine.cl. The kernel
// defines the minimised function and the method. No bake uses this code.
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
  std::vector<MeanLobe> lobes;                // results of EM
  std::vector<std::vector<MeanLobe>> beside;  // lobes of up to four neighbouring texels, each with the same number of
                                              // lobes
};

/// Refines the lobes of a texel in `steps` iterations, and returns the refined lobes.
std::vector<MeanLobe> refine(const RefinedTexel& texel, int steps);

/// Returns the value of the minimised function for the given lobes of the texel, without its constant terms.
double refined_energy(const RefinedTexel& texel, const std::vector<MeanLobe>& lobes);

/// Returns the error that is used to compare refined lobes with the lobes of EM. It is the sum of the relative L1
/// errors of the highlights over the half vectors of kernels/shared/movmf_refine.h. The error is at least 0.
double seen_error(const RefinedTexel& texel, const std::vector<MeanLobe>& lobes);

}  // namespace multum::reference
