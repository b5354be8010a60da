// SPDX-License-Identifier: Apache-2.0
// Finds the visible object and triangle at the centre of each pixel, which is an item buffer (Weghorst, Hooper and
// Greenberg 1984). Texture mapping uses this visibility (Hakura et al. 2000, section 3.4).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/formats/mesh/object_mesh.h"

namespace multum {

/// The visible surface at each pixel's centre, found by a z-buffer in double precision. The value -1 means that nothing
/// is visible.
struct ItemBuffer {
  int width = 0, height = 0;
  std::vector<std::int32_t> object;    // index into the objects
  std::vector<std::int32_t> triangle;  // index into the triangles of that object
  std::vector<float> depth;            // distance along -z of camera space; infinite where nothing is visible
};

struct PlacedObject {
  const ObjectMesh* mesh;
  glm::dmat4 object_to_camera;
};

/// The largest width and height of an item buffer, in pixels.
constexpr int kItemBufferSideMax = 16384;

/// Row 0 is at the top. Triangles that cross the near plane are clipped. Both sides of a triangle are drawn. A pixel
/// whose centre is on an edge of two triangles belongs to exactly one of them. At equal depth the first triangle wins.
ItemBuffer draw_item_buffer(const std::vector<PlacedObject>& objects, const glm::dmat4& projection, int width,
                            int height);

/// Returns the share of each pixel that each of `object_count` objects covers, as width / factor * height / factor
/// floats per object. The item buffer is `factor` times as wide and as high as the picture.
std::vector<std::vector<float>> item_coverage(const ItemBuffer& items, int factor, int object_count);

}  // namespace multum
