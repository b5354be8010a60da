// SPDX-License-Identifier: Apache-2.0
// Computes the reference of kernels/image_transform.cl in double precision. The code follows the definitions directly,
// and does not use the factorisation of the kernels. A cosine coefficient is a sum over its block, and a wavelet
// coefficient is a sum over its line.
#pragma once

#include <cstddef>
#include <vector>

namespace multum::reference {

/// Returns coefficients [block][v][u] for an image [height][width]. Each coefficient is a sum over the samples of the
/// block, in which each sample is multiplied by `c(v, y) * c(u, x)`. Here `c(k, i) = sqrt(2 / n) * cos(pi (2 i + 1) k /
/// 2 n)`, multiplied by `sqrt(1 / 2)` for k = 0. If a block extends beyond the right or lower border, the last column
/// or row is repeated.
std::vector<double> block_cosines(const std::vector<double>& image, std::size_t width, std::size_t height,
                                  std::size_t side);

/// Filters a line of n samples, which is mirrored at its ends, with the analysis filters of the biorthogonal 9/7
/// wavelets. The result contains ceil(n / 2) low-pass coefficients, which are the sums of `h(j) * x(2 k + j)`, followed
/// by floor(n / 2) high-pass coefficients, which are the sums of `g(j) * x(2 k + 1 + j)`. A line of one sample does not
/// change.
std::vector<double> wavelet_line(const std::vector<double>& line);

/// Transforms `depth` levels of an image [height][width], rows before columns. Each level after the first transforms
/// the quarter of the previous level that contains only low frequencies.
std::vector<double> wavelets(std::vector<double> image, std::size_t width, std::size_t height, int depth);

}  // namespace multum::reference
