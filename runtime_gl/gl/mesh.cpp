// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/gl/mesh.h"

#include <cstddef>

#include "host/foundation/base/error.h"

namespace multum::gl {

Mesh::Mesh(const GlFunctions& gl) : gl_(&gl) {
  gl.CreateBuffers(2, buffers_);
  gl.CreateVertexArrays(1, &vertex_array_);
}

Mesh::Mesh(const GlFunctions& gl, const MeshData& data) : Mesh(gl) {
  MULTUM_CHECK(!data.vertices.empty() && !data.indices.empty());
  index_count_ = static_cast<GLsizei>(data.indices.size());
  gl.NamedBufferStorage(buffers_[0], static_cast<GLsizeiptr>(data.vertices.size() * sizeof(MeshVertex)),
                        data.vertices.data(), 0);
  gl.NamedBufferStorage(buffers_[1], static_cast<GLsizeiptr>(data.indices.size() * sizeof(std::uint32_t)),
                        data.indices.data(), 0);
  gl.VertexArrayVertexBuffer(vertex_array_, 0, buffers_[0], 0, sizeof(MeshVertex));
  gl.VertexArrayElementBuffer(vertex_array_, buffers_[1]);
  const struct {
    GLint size;
    std::size_t offset;
  } attributes[] = {{3, offsetof(MeshVertex, position)},
                    {3, offsetof(MeshVertex, normal)},
                    {4, offsetof(MeshVertex, tangent)},
                    {2, offsetof(MeshVertex, uv)}};
  for (GLuint i = 0; i < 4; ++i) {
    gl.EnableVertexArrayAttrib(vertex_array_, i);
    gl.VertexArrayAttribFormat(vertex_array_, i, attributes[i].size, GL_FLOAT, GL_FALSE,
                               static_cast<GLuint>(attributes[i].offset));
    gl.VertexArrayAttribBinding(vertex_array_, i, 0);
  }
  check_gl(gl, "uploading a mesh of " + std::to_string(data.vertices.size()) + " vertices");
}

Mesh::~Mesh() {
  gl_->DeleteVertexArrays(1, &vertex_array_);
  gl_->DeleteBuffers(2, buffers_);
}

void Mesh::draw() const {
  gl_->BindVertexArray(vertex_array_);
  gl_->DrawElements(GL_TRIANGLES, index_count_, GL_UNSIGNED_INT, nullptr);
}

}  // namespace multum::gl
