// SPDX-License-Identifier: Apache-2.0
// Finds the object and triangle that is seen at the centre of each pixel: an item buffer (Weghorst, Hooper and
// Greenberg 1984), from which texture mapping takes what is visible (Hakura et al. 2000, section 3.4).
#pragma once

#include <cstdint>
#include <vector>

#include <glm/mat4x4.hpp>

#include "host/formats/mesh/object_mesh.h"

namespace multum {

/// What covers each pixel's centre, by a z-buffer in double precision: -1 where nothing does.
struct ItemBuffer {
  int width = 0, height = 0;
  std::vector<std::int32_t> object;    // index into the objects
  std::vector<std::int32_t> triangle;  // of that object
  std::vector<float> depth;            // distance along -z of camera space; infinite where nothing is
};

struct PlacedObject {
  const ObjectMesh* mesh;
  glm::dmat4 object_to_camera;
};

/// Width and height in pixels that an item buffer may have.
constexpr int kItemBufferSideMax = 16384;

/// Row 0 at the top. Triangles that cross the near plane are clipped; both sides of a triangle are drawn. A pixel whose
/// centre lies on an edge that two triangles share belongs to exactly one of them; at equal depth the first wins.
ItemBuffer draw_item_buffer(const std::vector<PlacedObject>& objects, const glm::dmat4& projection, int width,
                            int height);

/// Share of each pixel that each of `object_count` objects covers: width / factor * height / factor floats of each, of
/// an item buffer that is `factor` times as wide and as high as the picture.
std::vector<std::vector<float>> item_coverage(const ItemBuffer& items, int factor, int object_count);

}  // namespace multum
