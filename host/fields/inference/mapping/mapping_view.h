// SPDX-License-Identifier: Apache-2.0
// Describes one picture of an object, which is the input of texture mapping (Hakura et al. 2000, section 3.4).
#pragma once

#include <glm/mat4x4.hpp>

#include "host/fields/inference/mapping/item_buffer.h"

namespace multum {

/// One picture that shows the object.
struct MappingView {
  glm::dmat4 object_to_camera;
  glm::dmat4 projection;
  const ItemBuffer* items;
  int object;  // the object's number in the item buffer
};

}  // namespace multum
