// SPDX-License-Identifier: Apache-2.0
// Computes eigenvectors of small symmetric matrices by cyclic Jacobi rotations (Golub and Van Loan, section 8.5): exact
// to rounding, in an order of operations that depends on nothing but the size.
#pragma once

#include <cstddef>
#include <vector>

namespace multum {

/// Orthonormal, by falling eigenvalue. `matrix`: [size][size], symmetric.
std::vector<std::vector<double>> symmetric_eigenvectors(std::vector<double> matrix, std::size_t size);

}  // namespace multum
