// SPDX-License-Identifier: Apache-2.0
// Fits mixtures of von Mises-Fisher lobes to a list of normals, on the host and in double precision. The bake's EM
// starts from these mixtures (host/bakes/movmf/movmf_start.h), and plans use them to estimate lobes (host/bakes/scene).
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include <glm/vec3.hpp>

namespace multum {

using Normals = std::vector<glm::dvec3>;

struct MixtureLobe {
  glm::dvec3 mu;
  double mean_length;
  double kappa;
  double amplitude;
};

struct MixtureFit {
  std::vector<MixtureLobe> lobes;
  double log_likelihood = -HUGE_VAL;
  double error = HUGE_VAL;
};

/// Returns lobes of equal amplitude around the normals whose indices are in `chosen`.
MixtureFit start_mixture(const Normals& normals, const std::vector<std::size_t>& chosen, bool is_shortened);

/// Runs EM in double precision (Han et al. 2007, section 7, Algorithm 1) without alignment. Each shortened normal
/// counts as `copies` normals (kernels/device/movmf_em.clh).
void iterate_mixture(MixtureFit& fit, const Normals& normals, int iterations, double kappa_max, double copies);

/// Returns the indices of `count` normals that are far apart: first the normal farthest from the mean, then repeatedly
/// the normal farthest from all chosen normals.
std::vector<std::size_t> farthest_first_normals(const Normals& normals, int count);

}  // namespace multum
