// SPDX-License-Identifier: Apache-2.0
#include "host/formats/mesh/mesh.h"

namespace multum {

TriangleMesh make_plane(float size) {
  TriangleMesh plane;
  const float half = 0.5f * size;
  plane.positions = {{-half, 0.0f, 0.0f}, {half, 0.0f, 0.0f}, {half, size, 0.0f}, {-half, size, 0.0f}};
  plane.uvs = {{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}};
  plane.normals.assign(4, {0.0f, 0.0f, 1.0f});
  plane.tangents.assign(4, {1.0f, 0.0f, 0.0f, 1.0f});
  plane.indices = {0, 1, 2, 0, 2, 3};
  plane.parts = {{"", 0, 0, 6}};
  return plane;
}

}  // namespace multum
