// SPDX-License-Identifier: Apache-2.0
// Computes the lowest possible errors of blocks of 4 x 4 texels in double precision, to test kernels/block_encoding.cl.
// For BC4, the code tries all pairs of endpoints. For the modes of BC7, a search begins at many starting values, which
// would be too slow for an encoder.
#pragma once

#include <array>

namespace multum::reference {

/// The values of a block, from 0 to 255, row by row.
using BlockValues = std::array<double, 16>;

/// Returns the smallest sum of squared differences that a BC4 block can have.
double least_scalar_error(const BlockValues& values);

/// The red, green and blue values of a block.
using BlockColours = std::array<BlockValues, 3>;

/// Searches for the smallest sum of squared differences of red, green and blue that a BC7 block of mode 1, 4, 5 or 6
/// can have if alpha is 255, and returns this sum. The search takes hundreds of milliseconds.
double colour_error_by_search(const BlockColours& colours);

}  // namespace multum::reference
