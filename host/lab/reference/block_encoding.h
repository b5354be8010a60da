// SPDX-License-Identifier: Apache-2.0
// Least errors of blocks of 4 x 4 texels, in double, to which kernels/block_encoding.cl is held. BC4 by trying all
// ends; BC7's modes by search from many starts, which no encoder that has to be quick makes.
#pragma once

#include <array>

namespace multum::reference {

/// Values of a block, 0 to 255, row by row.
using BlockValues = std::array<double, 16>;

/// The least sum of squared differences that a block of BC4 has.
double least_scalar_error(const BlockValues& values);

/// Red, green and blue.
using BlockColours = std::array<BlockValues, 3>;

/// The least sum of squared differences of red, green and blue that the search finds for a block of BC7 of the modes 1,
/// 4, 5 and 6, with alpha 255. Hundreds of milliseconds.
double colour_error_by_search(const BlockColours& colours);

}  // namespace multum::reference
