// SPDX-License-Identifier: Apache-2.0
// Starts texture inference where no neighbouring sample is solved: every texel is the mean of the pixels that look at
// it, and what few look at is taken from the coarser level (Gortler et al. 1996, "The lumigraph", pull-push).
#pragma once

#include <array>
#include <vector>

#include "host/formats/asset/mip_layout.h"

namespace multum {

/// `sums`: weighted sums of the pixels that look at each texel; `weights`: of the weights alone. Three a texel, of
/// every level.
std::vector<float> start_texels(const MipLayout& layout, const std::vector<std::array<float, 4>>& sums,
                                const std::vector<float>& weights);

}  // namespace multum
