// SPDX-License-Identifier: Apache-2.0
// Normal maps made by a rule.
#pragma once

#include <functional>

#include <glm/vec3.hpp>

#include "host/image/normal_map.h"

namespace multum::testing {

/// normal_at(x, y) as it is, unit or not; rows from the top.
inline NormalMap make_map(int width, int height, const std::function<glm::dvec3(int, int)>& normal_at) {
  NormalMap map;
  map.width = width;
  map.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const glm::vec3 n(normal_at(x, y));
      map.x.push_back(n.x);
      map.y.push_back(n.y);
      map.z.push_back(n.z);
    }
  return map;
}

}  // namespace multum::testing
