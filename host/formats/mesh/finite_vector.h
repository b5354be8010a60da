// SPDX-License-Identifier: Apache-2.0
// Returns whether every component of a vector is finite. Every check of a mesh uses this function.
#pragma once

#include <cmath>

#include <glm/vec3.hpp>

namespace multum {

inline bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace multum
