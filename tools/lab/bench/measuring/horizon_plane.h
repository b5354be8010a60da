// SPDX-License-Identifier: Apache-2.0
// Makes multum-view's plane, which runs to the horizon of the default camera (runtime_gl/render/camera.h).
#pragma once

#include "runtime_gl/gl/mesh.h"

namespace multum::bench {

/// On the plane, z is 0, x runs from -side / 2 to side / 2, y from 0 to `side`, and texture coordinates from 0 to 1.
inline gl::MeshData horizon_plane(float side) {
  gl::MeshData mesh;
  for (const float v : {0.0f, 1.0f})
    for (const float u : {0.0f, 1.0f}) {
      gl::MeshVertex vertex{};
      vertex.position = {side * (u - 0.5f), side * v, 0.0f};
      vertex.normal = {0.0f, 0.0f, 1.0f};
      vertex.uv = {u, v};
      vertex.tangent = {1.0f, 0.0f, 0.0f, 1.0f};
      mesh.vertices.push_back(vertex);
    }
  mesh.indices = {0, 1, 2, 2, 1, 3};
  return mesh;
}

}  // namespace multum::bench
