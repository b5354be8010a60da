// SPDX-License-Identifier: Apache-2.0
// Runs spherical EM in double precision, in its simplest form, as the reference for kernels/movmf_em_*.cl. The code
// follows Han et al. 2007, section 7, Algorithm 1, equations 15-16, with the corrections in
// docs/contributing/ALGORITHMS.md. No bake uses it.
#pragma once

#include <vector>

#include <glm/vec3.hpp>

namespace multum::reference {

struct Sample {
  glm::dvec3 normal;  // normal, which may be shorter than 1
  double weight = 1.0;
};

struct Lobe {
  glm::dvec3 mu;  // unit vector
  double kappa;
  double amplitude;
};

struct Moments {
  glm::dvec3 r;   // mean vector of the lobe's normals, or the lobe's last direction if the lobe has no normals
  double spread;  // 1 - |r|
  double amplitude;
};

struct EmOptions {
  int iterations;
  double kappa_cap;
  double kappa_cap_slope;
  std::vector<glm::dvec3> prior;  // the sum C sum_k a_k mu_k of each lobe; empty if there is no prior
  double copies = 1.0;            // factor by which the log densities are multiplied before a sample is divided among
                                  // the lobes
};

/// These functions compute A(kappa) = coth kappa - 1/kappa for every kappa > 0, and its inverse by bisection.
double mean_length(double kappa);
double kappa_of_mean_length(double r);

/// Returns the logarithm of the von Mises-Fisher density at cosine t.
double log_vmf(double t, double kappa);

/// Runs EM and returns the moments of the last E-step. Stores the parameters of this E-step in `lobes`.
std::vector<Moments> fit(const std::vector<Sample>& samples, std::vector<Lobe>& lobes, const EmOptions& options);

}  // namespace multum::reference
