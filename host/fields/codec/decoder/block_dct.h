// SPDX-License-Identifier: Apache-2.0
// The cosine transform of square blocks of 8, 16 or 32 samples a side, orthonormal (DCT-II), and its inverse.
#pragma once

#include <span>

namespace multum {

/// True for the sides that there are: 8, 16, 32.
bool is_dct_side(int side);

/// C, [side][side]: row k the cosine of frequency k.
std::span<const float> dct_cosines(int side);

/// coefficients[v][u] = C samples C^T: u frequency along rows, v along columns. Both of side * side values; they may be
/// the same.
void forward_dct(int side, std::span<const float> samples, std::span<float> coefficients);
/// Zeros beyond the lowest rows and columns of coefficients cost nothing.
void inverse_dct(int side, std::span<const float> coefficients, std::span<float> samples);

}  // namespace multum
