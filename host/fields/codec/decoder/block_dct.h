// SPDX-License-Identifier: Apache-2.0
// Computes the orthonormal cosine transform (DCT-II) of square blocks of 8, 16 or 32 samples per side, and its inverse.
#pragma once

#include <span>

namespace multum {

/// Returns true for the supported sides, which are 8, 16 and 32.
bool is_dct_side(int side);

/// Returns C, [side][side]. Row k is the cosine of frequency k.
std::span<const float> dct_cosines(int side);

/// Computes coefficients[v][u] = C samples C^T, where u is the frequency along rows and v is the frequency along
/// columns. Both spans have side * side values and may be the same.
void forward_dct(int side, std::span<const float> samples, std::span<float> coefficients);
/// Saves time by skipping the highest frequencies if their rows or columns are zero.
void inverse_dct(int side, std::span<const float> coefficients, std::span<float> samples);

}  // namespace multum
