// SPDX-License-Identifier: Apache-2.0
// Defines a triangle mesh on the GPU. Callers pass MeshData. The runtime reads no mesh files.
#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

struct MeshVertex {
  glm::vec3 position;
  glm::vec3 normal;   // unit vector
  glm::vec4 tangent;  // unit vector along growing u; w is the handedness: bitangent = w * cross(normal, tangent), along
                      // growing v
  glm::vec2 uv;       // v grows upwards in the image
};

struct MeshData {
  std::vector<MeshVertex> vertices;
  std::vector<std::uint32_t> indices;  // three per triangle
};

/// A vertex array without attributes, for shaders that generate their own triangle.
class EmptyMesh {
 public:
  explicit EmptyMesh(const GlFunctions& gl) : gl_(&gl) { gl.CreateVertexArrays(1, &vertex_array_); }
  ~EmptyMesh() { gl_->DeleteVertexArrays(1, &vertex_array_); }
  EmptyMesh(const EmptyMesh&) = delete;
  EmptyMesh& operator=(const EmptyMesh&) = delete;
  void draw_triangle() const {
    gl_->BindVertexArray(vertex_array_);
    gl_->DrawArrays(GL_TRIANGLES, 0, 3);
  }

 private:
  const GlFunctions* gl_;
  GLuint vertex_array_ = 0;
};

class Mesh {
 public:
  Mesh(const GlFunctions& gl, const MeshData& data);
  ~Mesh();
  Mesh(const Mesh&) = delete;
  Mesh& operator=(const Mesh&) = delete;

  /// Draws the mesh with attributes 0 to 3, which are position, normal, tangent and uv.
  void draw() const;

 private:
  explicit Mesh(const GlFunctions& gl);  // creates the names before anything can throw

  const GlFunctions* gl_;
  GLsizei index_count_ = 0;
  GLuint vertex_array_ = 0;
  GLuint buffers_[2] = {0, 0};
};

}  // namespace multum::gl
