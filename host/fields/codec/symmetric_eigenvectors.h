// SPDX-License-Identifier: Apache-2.0
// Computes eigenvectors of small symmetric matrices by cyclic Jacobi rotations (Golub and Van Loan, section 8.5). The
// result is exact except for rounding errors, and the order of operations depends only on the size.
#pragma once

#include <cstddef>
#include <vector>

namespace multum {

/// Returns orthonormal eigenvectors in the order of descending eigenvalues. `matrix` is symmetric, [size][size].
std::vector<std::vector<double>> symmetric_eigenvectors(std::vector<double> matrix, std::size_t size);

}  // namespace multum
