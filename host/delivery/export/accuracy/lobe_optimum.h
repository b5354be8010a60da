// SPDX-License-Identifier: Apache-2.0
// Searches for the best single lobe under given lights. Exports are compared with this lobe. Its error is an upper
// bound of the lowest possible error, because the search may end too early.
#pragma once

#include "host/delivery/export/accuracy/cell_reference.h"

namespace multum {

/// Returns the lobe with the lowest relative L1 error plus |energy - 1| that the simplex method finds from `start`
/// (Nelder and Mead 1965). `alpha_min` is the smallest alpha that the result can have.
GgxLobe find_lobe_optimum(const ReferenceLights& lights, const GgxLobe& start, bool is_anisotropic, double alpha_min);

}  // namespace multum
