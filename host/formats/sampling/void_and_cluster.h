// SPDX-License-Identifier: Apache-2.0
// Makes dither masks of blue noise by the void-and-cluster method (Ulichney, "The void-and-cluster method for dither
// array generation", Proc. SPIE 1913, 1993).
#pragma once

#include <cstdint>
#include <vector>

namespace multum {

/// Returns a mask that repeats in both directions. It holds the ranks 0 to side^2 - 1, each once, row by row. For every
/// n, the n lowest ranks are evenly spread. `side` is 8 to 256. Each seed gives a different mask.
std::vector<int> void_and_cluster(int side, std::uint32_t seed);

}  // namespace multum
