// SPDX-License-Identifier: Apache-2.0
// Reference in double precision of kernels/image_transform.cl: the definitions, not their factors. A cosine coefficient
// is the sum over its block; a wavelet coefficient the sum over the line of the filters that lifting is a factoring of.
#pragma once

#include <cstddef>
#include <vector>

namespace multum::reference {

/// [block][v][u] of an image [height][width]: sum of c(v, y) c(u, x) samples, c(k, i) = sqrt(2 / n) cos(pi (2 i + 1) k
/// / 2 n), by sqrt(1 / 2) for k = 0; samples beyond the right and lower borders are the outermost ones.
std::vector<double> block_cosines(const std::vector<double>& image, std::size_t width, std::size_t height,
                                  std::size_t side);

/// A line of n samples, mirrored at its outermost ones, through the analysis filters of the biorthogonal 9/7 wavelets:
/// ceil(n / 2) low coefficients, sum of h(j) x(2 k + j), then floor(n / 2) high ones, sum of g(j) x(2 k + 1 + j). A
/// line of one sample stays.
std::vector<double> wavelet_line(const std::vector<double>& line);

/// `depth` levels of an image [height][width], rows, then columns; of each further level the low quarter.
std::vector<double> wavelets(std::vector<double> image, std::size_t width, std::size_t height, int depth);

}  // namespace multum::reference
