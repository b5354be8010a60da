// SPDX-License-Identifier: Apache-2.0
// Where EM starts when there is no parent: farthest-first choice of normals (Hochbaum and Shmoys; Han et al. 2007,
// section 7.2, uses it for lobes).
#pragma once

#include <vector>

#include "host/image/normal_map.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// The finest texels [x0, x1) x [y0, y1) of `map`.
struct TexelRectangle {
  int x0, y0, x1, y1;
};

/// `lobe_count` lobes of equal amplitude and kappa 20, far apart: the normal farthest from the mean first, then each time
/// the one farthest from those chosen. At most about 2^14 normals on a regular grid are looked at.
std::vector<MultumVmfLobe> farthest_first_lobes(const NormalMap& map, const TexelRectangle& where, int lobe_count);

}  // namespace multum
