// SPDX-License-Identifier: Apache-2.0
// Computes start values for texture inference if no neighbouring sample is solved. Every texel is the mean of the
// pixels that read it. Texels with little weight take their value from the coarser level (pull-push: Gortler et al.
// 1996, "The lumigraph").
#pragma once

#include <array>
#include <vector>

#include "host/formats/asset/mip_layout.h"

namespace multum {

/// `sums` has the weighted sum of the pixels that read each texel, and `weights` the sum of their weights. Returns
/// three values per texel of every level.
std::vector<float> start_texels(const MipLayout& layout, const std::vector<std::array<float, 4>>& sums,
                                const std::vector<float>& weights);

}  // namespace multum
