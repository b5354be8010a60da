// SPDX-License-Identifier: Apache-2.0
// Computes the lowest errors of blocks of 4 x 4 texels, in double precision, to test kernels/block_encoding.cl. For
// BC4, tries all end points. For BC7, searches the modes from many starts, which is too slow for an encoder.
#pragma once

#include <array>

namespace multum::reference {

/// Values of a block, 0 to 255, row by row.
using BlockValues = std::array<double, 16>;

/// Returns the lowest sum of squared differences of a BC4 block.
double least_scalar_error(const BlockValues& values);

/// Red, green and blue.
using BlockColours = std::array<BlockValues, 3>;

/// Returns the lowest sum of squared differences of red, green and blue that a search finds for a BC7 block of modes 1,
/// 4, 5 and 6 with alpha 255. Takes hundreds of milliseconds.
double colour_error_by_search(const BlockColours& colours);

}  // namespace multum::reference
