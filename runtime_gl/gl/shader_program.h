// SPDX-License-Identifier: Apache-2.0
// Defines a linked vertex and fragment shader. A variant is a set of flags, each of which becomes one #define between
// the version line and the shared text. Only the requested variants are compiled.
#pragma once

#include <string>
#include <vector>

#include "runtime_gl/gl/gl_functions.h"

namespace multum::gl {

/// The source texts, concatenated in order, without version lines.
struct ShaderSources {
  std::string name;                // name in messages: "movmf"
  std::vector<std::string> flags;  // "MULTUM_LOBE_COUNT 4"
  std::vector<std::string> vertex;
  std::vector<std::string> fragment;
};

class ShaderProgram {
 public:
  /// Throws Error(kEnvironment) with the driver's log, the variant's name and its flags.
  ShaderProgram(const GlFunctions& gl, const ShaderSources& sources);
  ~ShaderProgram();
  ShaderProgram(const ShaderProgram&) = delete;
  ShaderProgram& operator=(const ShaderProgram&) = delete;

  /// Returns the names of uniforms that affect an output. Names of arrays have no brackets.
  std::vector<std::string> active_uniforms() const;
  void use() const { gl_->UseProgram(id_); }
  // Setting a uniform that the variant does not use has no effect, as with location -1 of GL.
  void set(const char* uniform, int value) const;
  void set(const char* uniform, float value) const;
  void set_floats(const char* uniform, const float* values, int count) const;
  void set_vec2(const char* uniform, const float* values) const;
  void set_vec3(const char* uniform, const float* values, int count) const;
  void set_mat4(const char* uniform, const float* column_major) const;
  /// Assigns the texture units first_unit, first_unit + 1, ... to an array of samplers.
  void set_units(const char* uniform, int first_unit, int count) const;

 private:
  explicit ShaderProgram(const GlFunctions& gl);
  GLint location(const char* uniform) const { return gl_->GetUniformLocation(id_, uniform); }

  const GlFunctions* gl_;
  GLuint id_ = 0;
};

}  // namespace multum::gl
