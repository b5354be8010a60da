// SPDX-License-Identifier: Apache-2.0
// Fits the table of ggx_lobe.h to quadrature of the convolution, cell by cell, by Levenberg-Marquardt (Eigen).
// Minimizes the integral over the sphere of (fit - exact)^2 / exact, which is close to relative L1, plus a penalty for
// differences from the neighbouring cells. The penalty is needed because several shapes fit equally well if a lobe
// fills the sphere or hides GGX. Without the penalty, filtering between unlike shapes would be inaccurate.
#pragma once

#include <vector>

#include "host/formats/brdf/ggx_lobe.h"

namespace multum {

/// Returns the integral of GGX(angle of n and h) vMF(n; mu, kappa) dn. The relative error is below 1e-6 for alpha from
/// 1e-3 to 1 and kappa from 1e-3 to 1e6. `theta` is the angle between mu and h, 0..pi.
double convolved_ggx_facets(double alpha, double kappa, double theta);

/// Returns kGgxLobeTableSide^2 shapes, row by row as in ggx_lobe_table(). Takes a few seconds.
std::vector<GgxLobeShape> fit_ggx_lobe_table();

}  // namespace multum
