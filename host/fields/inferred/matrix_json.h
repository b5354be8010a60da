// SPDX-License-Identifier: Apache-2.0
// Reads and writes the JSON that probe requests and manifests of inferred textures share. This is the sampler's
// anisotropy, the picture's size, and 4 x 4 matrices for column vectors, written as four rows of four numbers.
#pragma once

#include <array>
#include <string>

#include <glm/mat4x4.hpp>
#include <nlohmann/json.hpp>

#include "host/fields/inferred/texture_mapping.h"
#include "host/foundation/base/error.h"

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

/// Throws nlohmann::json::exception. Throws Error(kInput) for values beyond OpenGL's range, because wide footprints
/// would take too many draws.
inline float anisotropy_from_json(const nlohmann::json& json) {
  const auto anisotropy = json.get<double>();
  if (!(anisotropy >= 1.0 && anisotropy <= 16.0))
    throw Error(ErrorCode::kInput, "an anisotropy is " + json.dump() + ", expected 1 to 16");
  return static_cast<float>(anisotropy);
}

/// Throws Error(kInput).
inline void check_picture_size(int width, int height, int supersampling) {
  constexpr int kSupersamplingMax = 8;  // limit in docs/reference/animation_jobs.md
  if (width < 1 || height < 1 || width > kGpuSideMax || height > kGpuSideMax || supersampling < 1 ||
      supersampling > kSupersamplingMax)
    throw Error(ErrorCode::kInput, "the picture is " + std::to_string(width) + " x " + std::to_string(height) +
                                       " pixels with supersampling " + std::to_string(supersampling) +
                                       ", expected 1 to 16384 per side and 1 to 8");
}

}  // namespace multum
