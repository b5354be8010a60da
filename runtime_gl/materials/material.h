// SPDX-License-Identifier: Apache-2.0
// What a surface is made of: the textures of one representation of its normals, and the GLSL that reads them
// (shaders/common/reflection.glsl says what that must have). The renderer knows no representation by name.
#pragma once

#include <string>
#include <vector>

#include "runtime_gl/gl/shader_program.h"

namespace multum::gl {

/// GLSL of a shader's variant: each flag becomes one #define, texts follow each other.
struct ShaderParts {
  std::vector<std::string> flags;
  std::vector<const char*> texts;  // of embedded_shaders.h
};

class Material {
 public:
  virtual ~Material() = default;
  /// In messages: "movmf".
  virtual const char* name() const = 0;
  /// The file of surface/, after what it needs of common/ and brdf/.
  virtual ShaderParts shader_parts() const = 0;
  /// Gives textures units from 0 on and the shader's samplers these units, and sets uniforms of its own. Returns the
  /// first unit that is free.
  virtual int bind(const ShaderProgram& shader) const = 0;
  /// The order to which the surface takes the BRDF's zonal coefficients (u_zonal), or -1: it takes none.
  virtual int zonal_order() const { return -1; }

 protected:
  Material() = default;
  Material(Material&&) = default;
};

}  // namespace multum::gl
