// SPDX-License-Identifier: Apache-2.0
// Fits the table of ggx_lobe.h to quadrature of the convolution, cell by cell, by Levenberg and Marquardt (Eigen's).
// Minimised is the integral over the sphere of (fit - exact)^2 / exact, near relative L1, plus a pull towards the
// neighbouring cells: where a lobe fills the sphere, or hides what GGX adds, several shapes do, and a filter between
// unlike ones would be off.
#pragma once

#include <vector>

#include "host/formats/brdf/ggx_lobe.h"

namespace multum {

/// The convolution integral of GGX(angle of n and h) vMF(n; mu, kappa) dn, relative error below 1e-6 for alpha 1e-3 to
/// 1, kappa 1e-3 to 1e6. `theta`: angle of mu and h, 0..pi.
double convolved_ggx_facets(double alpha, double kappa, double theta);

/// kGgxLobeTableSide^2 shapes, row by row as ggx_lobe_table() has them. Some seconds.
std::vector<GgxLobeShape> fit_ggx_lobe_table();

}  // namespace multum
