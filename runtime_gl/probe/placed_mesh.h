// SPDX-License-Identifier: Apache-2.0
// Mesh of an object, placed as one sample of an animation has it.
#pragma once

#include <glm/mat4x4.hpp>

#include "runtime_gl/gl/mesh.h"

namespace multum::gl {

struct PlacedMesh {
  const Mesh* mesh;
  glm::mat4 object_to_clip;
};

/// Rows of a supersampled picture that are drawn at a time, counted from below, even: buffers of at most
/// 256 MiB. The probe and the pictures share it, since the place in the buffer enters the rounding of coordinates.
int band_row_count(int sub_width, int sub_height, int supersampling);

}  // namespace multum::gl
