// SPDX-License-Identifier: Apache-2.0
// Where EM starts when there is no parent to start from.
#pragma once

#include <cstdint>
#include <vector>

#include "host/image/normal_map.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// The finest texels [x0, x1) x [y0, y1) of `map`.
struct TexelRectangle {
  int x0, y0, x1, y1;
};

/// `lobe_count` lobes of equal amplitude and kappa 20, far apart: the normal farthest from the mean first, then each
/// time the one farthest from those chosen (Hochbaum and Shmoys; Han et al. 2007, section 7.2, choose among lobes so).
/// At most about 2^14 normals on a regular grid are looked at.
std::vector<MultumVmfLobe> farthest_first_lobes(const NormalMap& map, const TexelRectangle& where, int lobe_count);

struct StartSearch {
  int lobe_count = 4;
  float kappa_max = 1000.0f;  // cap inside EM
  std::uint64_t seed = 1;
  int threads = 1;
};

/// The most likely of many EM fits to a sample of the whole map, in double: what the coarsest level starts from. EM
/// from the farthest-first choice alone ends in poor local optima (one flat and two facets of a groove shared by three
/// wide lobes: 64 % error at the coarsest level of the four-quarter map, 6 % from here), and every finer level inherits
/// them.
std::vector<MultumVmfLobe> likeliest_lobes(const NormalMap& map, const StartSearch& search);

}  // namespace multum
