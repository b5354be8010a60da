// SPDX-License-Identifier: Apache-2.0
// 4 x 4 matrices as JSON: four rows of four numbers, for column vectors.
#pragma once

#include <array>

#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>

namespace multum {

inline nlohmann::json matrix_json(const glm::dmat4& m) {
  nlohmann::json rows = nlohmann::json::array();
  for (int r = 0; r < 4; ++r) rows.push_back({m[0][r], m[1][r], m[2][r], m[3][r]});
  return rows;
}

/// Throws nlohmann::json::exception.
inline glm::dmat4 matrix_from_json(const nlohmann::json& json) {
  const auto rows = json.get<std::array<std::array<double, 4>, 4>>();
  glm::dmat4 m;
  for (int r = 0; r < 4; ++r)
    for (int c = 0; c < 4; ++c) m[c][r] = rows[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
  return m;
}

}  // namespace multum
