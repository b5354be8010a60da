// SPDX-License-Identifier: Apache-2.0
// Computes the reference of kernels/image_transform.cl in double precision. Values are computed directly from the
// definitions, not by the factorisation that the kernels use. A cosine coefficient is a sum over its block, and a
// wavelet coefficient is a sum over the line.
#pragma once

#include <cstddef>
#include <vector>

namespace multum::reference {

/// Returns coefficients [block][v][u] for an image [height][width]. Each coefficient is the sum of the samples, each
/// multiplied by `c(v, y) * c(u, x)`. Here `c(k, i) = sqrt(2 / n) * cos(pi (2 i + 1) k / 2 n)`, multiplied by `sqrt(1 /
/// 2)` for k = 0. Blocks that extend beyond the right or lower border repeat the last column or row.
std::vector<double> block_cosines(const std::vector<double>& image, std::size_t width, std::size_t height,
                                  std::size_t side);

/// Filters a line of n samples, mirrored at its ends, by the analysis filters of the biorthogonal 9/7 wavelets. First
/// returns ceil(n / 2) low coefficients, which are the sums of `h(j) * x(2 k + j)`. Then returns floor(n / 2) high
/// coefficients, the sums of `g(j) * x(2 k + 1 + j)`. A line of one sample does not change.
std::vector<double> wavelet_line(const std::vector<double>& line);

/// Transforms an image [height][width] by `depth` levels, rows before columns. Each further level transforms the
/// quarter of the previous level that contains only low frequencies.
std::vector<double> wavelets(std::vector<double> image, std::size_t width, std::size_t height, int depth);

}  // namespace multum::reference
