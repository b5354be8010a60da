// SPDX-License-Identifier: Apache-2.0
// Computes the lowest possible errors of blocks of 4 x 4 texels in double, to test kernels/block_encoding.cl. For BC4,
// all pairs of endpoints are tried. For the modes of BC7, a search begins at many starting values, which would be too
// slow in an encoder.
#pragma once

#include <array>

namespace multum::reference {

/// The values of a block, from 0 to 255, row by row.
using BlockValues = std::array<double, 16>;

/// Returns the least sum of squared differences that a BC4 block can have.
double least_scalar_error(const BlockValues& values);

/// The red, green and blue values of a block.
using BlockColours = std::array<BlockValues, 3>;

/// Returns the least sum of squared differences of red, green and blue that a search finds for a BC7 block of modes 1,
/// 4, 5 and 6 with alpha 255. The search takes hundreds of milliseconds.
double colour_error_by_search(const BlockColours& colours);

}  // namespace multum::reference
