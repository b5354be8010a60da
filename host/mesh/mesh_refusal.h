// SPDX-License-Identifier: Apache-2.0
// What every check of a mesh needs.
#pragma once

#include <cmath>
#include <string>

#include <glm/vec3.hpp>

#include "host/base/error.h"

namespace multum {

/// Throws Error(kInput): "PATH: WHAT".
[[noreturn]] inline void refuse_mesh(const std::string& path, const std::string& what) {
  throw Error(ErrorCode::kInput, path + ": " + what);
}

inline bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

}  // namespace multum
