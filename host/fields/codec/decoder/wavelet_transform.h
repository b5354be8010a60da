// SPDX-License-Identifier: Apache-2.0
// Computes the wavelet transform of images of any size: the biorthogonal 9/7 filters of Cohen, Daubechies and Feauveau
// (1992) by lifting (Daubechies and Sweldens 1998), with borders mirrored at the outermost samples. The scaling is
// nearly orthonormal: in every band, an error of a coefficient causes about the same error in the image.
//
//      LL HL | HL        Coefficients replace the image's samples, the low half of a direction first:
//      LH HH |           ceil(n / 2) low ones, floor(n / 2) high ones.
//      ------+---
//       LH   | HH
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace multum {

/// A rectangle of coefficients of one kind.
struct WaveletBand {
  std::size_t x = 0, y = 0, width = 0, height = 0;
  int depth = 0;  // levels above the image: 1 is the finest
  int kind = 0;   // 0: LL, 1: HL (high along rows), 2: LH, 3: HH
};

/// Returns the number of levels. The sides are halved at most 6 times, while the shorter side has 8 samples or more.
int wavelet_depth(std::size_t width, std::size_t height);
/// Returns the bands that are not empty, starting with the coarsest. LL comes first, and then HL, LH and HH of each
/// level.
std::vector<WaveletBand> wavelet_bands(std::size_t width, std::size_t height);

/// Transforms in place, [height][width].
void forward_wavelet(std::size_t width, std::size_t height, std::span<float> samples);
void inverse_wavelet(std::size_t width, std::size_t height, std::span<float> coefficients);

}  // namespace multum
