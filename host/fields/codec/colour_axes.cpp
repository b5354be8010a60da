// SPDX-License-Identifier: Apache-2.0
#include "host/fields/codec/colour_axes.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "host/fields/codec/symmetric_eigenvectors.h"

namespace multum {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

double determinant(const Matrix& m) {
  return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) - m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
         m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

/// Returns the quaternion w, x, y, z of a rotation. The largest component is computed from the diagonal, and the others
/// from this component (Shepperd 1978).
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
  std::vector<double> values;
  for (const auto& row : covariance) values.insert(values.end(), row.begin(), row.end());
  const auto vectors = symmetric_eigenvectors(std::move(values), 3);
  Matrix rows{};
  for (std::size_t i = 0; i < 3; ++i) std::copy(vectors[i].begin(), vectors[i].end(), rows[i].begin());
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
