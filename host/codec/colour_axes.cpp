// SPDX-License-Identifier: Apache-2.0
#include "host/codec/colour_axes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace multum {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

/// Eigenvectors of a symmetric matrix as rows, by falling eigenvalue (cyclic Jacobi rotations).
Matrix eigenvectors(Matrix a) {
  Matrix v = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  // as columns
  constexpr int kSweeps = 30;                      // each squares what lies off the diagonal; a few suffice
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (const auto& [p, q] : {std::pair<std::size_t, std::size_t>{0, 1}, {0, 2}, {1, 2}}) {
      const double angle = 0.5 * std::atan2(2.0 * a[p][q], a[q][q] - a[p][p]);
      const double c = std::cos(angle), s = std::sin(angle);
      const auto turn = [c, s](double& x, double& y) {
        const double turned = c * x - s * y;
        y = s * x + c * y;
        x = turned;
      };
      for (std::size_t i = 0; i < 3; ++i) turn(a[i][p], a[i][q]);
      for (std::size_t i = 0; i < 3; ++i) turn(a[p][i], a[q][i]);
      for (std::size_t i = 0; i < 3; ++i) turn(v[i][p], v[i][q]);
    }
  std::array<std::size_t, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return a[i][i] > a[j][j]; });
  Matrix rows{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) rows[i][j] = v[j][order[i]];
  return rows;
}

double determinant(const Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Of a rotation, w, x, y, z: the largest of the four is taken from the diagonal, the others from it (Shepperd 1978).
std::array<double, 4> quaternion_of(const Matrix& r) {
  const double trace = r[0][0] + r[1][1] + r[2][2];
  const std::array<double, 4> squares = {trace, r[0][0], r[1][1], r[2][2]};
  const auto largest = std::max_element(squares.begin(), squares.end()) - squares.begin();
  if (largest == 0) return {1 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]};
  if (largest == 1) return {r[2][1] - r[1][2], 1 + 2 * r[0][0] - trace, r[0][1] + r[1][0], r[0][2] + r[2][0]};
  if (largest == 2) return {r[0][2] - r[2][0], r[0][1] + r[1][0], 1 + 2 * r[1][1] - trace, r[1][2] + r[2][1]};
  return {r[1][0] - r[0][1], r[0][2] + r[2][0], r[1][2] + r[2][1], 1 + 2 * r[2][2] - trace};
}

}  // namespace

ColourAxes colour_axes(const std::vector<std::vector<float>>& textures, const std::vector<float>& weights) {
  std::array<double, 3> mean{};
  double weight = 0.0;
  for (const auto& texture : textures)
    for (std::size_t i = 0; i < weights.size(); ++i) {
      weight += static_cast<double>(weights[i]);
      for (std::size_t c = 0; c < 3; ++c) mean[c] += static_cast<double>(weights[i] * texture[3 * i + c]);
    }
  ColourAxes axes;
  if (!(weight > 0.0)) return axes;
  for (std::size_t c = 0; c < 3; ++c) axes.mean[c] = static_cast<float>(mean[c] /= weight);
  Matrix covariance{};
  for (const auto& texture : textures)
    for (std::size_t i = 0; i < weights.size(); ++i)
      for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t d = 0; d < 3; ++d)
          covariance[c][d] += static_cast<double>(weights[i]) * (static_cast<double>(texture[3 * i + c]) - mean[c]) *
                              (static_cast<double>(texture[3 * i + d]) - mean[d]);
  Matrix rows = eigenvectors(covariance);
  if (rows[0][0] + rows[0][1] + rows[0][2] < 0.0)
    for (double& part : rows[0]) part = -part;
  if (determinant(rows) < 0.0)
    for (double& part : rows[2]) part = -part;
  auto quaternion = quaternion_of(rows);
  double length = 0.0;
  for (const double part : quaternion) length += part * part;
  for (std::size_t i = 0; i < 4; ++i)
    axes.quaternion[i] = static_cast<std::int16_t>(std::lround(32767.0 * quaternion[i] / std::sqrt(length)));
  return axes;
}

}  // namespace multum
