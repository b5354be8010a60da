// SPDX-License-Identifier: Apache-2.0
// The best that any one lobe can do under some lights, by search: what exports are measured by. An upper bound, since
// a search may end early.
#pragma once

#include "host/delivery/export/accuracy/cell_reference.h"

namespace multum {

/// The lobe of least relative L1 error plus |energy - 1| found from `start`, by the simplex method of Nelder and Mead
/// (1965). `alpha_min`: least alpha of the result.
GgxLobe find_lobe_optimum(const ReferenceLights& lights, const GgxLobe& start, bool is_anisotropic, double alpha_min);

}  // namespace multum
