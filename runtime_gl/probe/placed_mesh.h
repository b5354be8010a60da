// SPDX-License-Identifier: Apache-2.0
// Defines the mesh of an object at its place in one sample of an animation.
#pragma once

#include <glm/mat4x4.hpp>

#include "runtime_gl/gl/mesh.h"

namespace multum::gl {

struct PlacedMesh {
  const Mesh* mesh;
  glm::mat4 object_to_clip;
};

/// Returns the number of rows of a supersampled picture that are drawn at a time, counted from below. The number is
/// even, and buffers take at most 256 MiB. The probe and the pictures use the same number, because the place in the
/// buffer affects the rounding of coordinates.
int band_row_count(int sub_width, int sub_height, int supersampling);

}  // namespace multum::gl
