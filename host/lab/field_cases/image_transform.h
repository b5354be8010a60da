// SPDX-License-Identifier: Apache-2.0
// Computes the reference of kernels/image_transform.cl in double, from the definitions and not from their factors. A
// cosine coefficient is the sum over its block. A wavelet coefficient is the sum over the line with the filters that
// lifting factors.
#pragma once

#include <cstddef>
#include <vector>

namespace multum::reference {

/// Returns [block][v][u] for an image [height][width]: the sum of c(v, y) c(u, x) times the samples. c(k, i) = sqrt(2 /
/// n) cos(pi (2 i + 1) k / 2 n), times sqrt(1 / 2) for k = 0. Samples beyond the right and lower borders repeat the
/// outermost ones.
std::vector<double> block_cosines(const std::vector<double>& image, std::size_t width, std::size_t height,
                                  std::size_t side);

/// Filters a line of n samples, mirrored at its ends, by the analysis filters of the biorthogonal 9/7 wavelets.
/// Returns ceil(n / 2) low coefficients, sum of h(j) x(2 k + j), then floor(n / 2) high ones, sum of g(j) x(2 k + 1 +
/// j). A line of one sample does not change.
std::vector<double> wavelet_line(const std::vector<double>& line);

/// Transforms an image [height][width] by `depth` levels, rows before columns; each further level transforms the low
/// quarter.
std::vector<double> wavelets(std::vector<double> image, std::size_t width, std::size_t height, int depth);

}  // namespace multum::reference
