// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/symmetric_eigenvectors.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace multum {

std::vector<std::vector<double>> symmetric_eigenvectors(std::vector<double> matrix, std::size_t size) {
  std::vector<double> columns(size * size);
  for (std::size_t i = 0; i < size; ++i) columns[i * size + i] = 1.0;
  constexpr int kSweeps = 30;  // convergence is quadratic: about ten sweeps suffice for 64 rows
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (std::size_t p = 0; p < size; ++p)
      for (std::size_t q = p + 1; q < size; ++q) {
        if (matrix[p * size + q] == 0.0) continue;
        const double angle = 0.5 * std::atan2(2.0 * matrix[p * size + q], matrix[q * size + q] - matrix[p * size + p]);
        const double c = std::cos(angle), s = std::sin(angle);
        const auto turn = [c, s](double& x, double& y) {
          const double turned = c * x - s * y;
          y = s * x + c * y;
          x = turned;
        };
        for (std::size_t i = 0; i < size; ++i) turn(matrix[i * size + p], matrix[i * size + q]);
        for (std::size_t i = 0; i < size; ++i) turn(matrix[p * size + i], matrix[q * size + i]);
        for (std::size_t i = 0; i < size; ++i) turn(columns[i * size + p], columns[i * size + q]);
      }
  std::vector<std::size_t> order(size);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t i, std::size_t j) { return matrix[i * size + i] > matrix[j * size + j]; });
  std::vector<std::vector<double>> vectors(size, std::vector<double>(size));
  for (std::size_t i = 0; i < size; ++i)
    for (std::size_t j = 0; j < size; ++j) vectors[i][j] = columns[j * size + order[i]];
  return vectors;
}

}  // namespace multum
