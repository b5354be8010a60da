// SPDX-License-Identifier: Apache-2.0
// Material of a surface: the textures of one representation of its normals, and the GLSL that reads them
// (shaders/common/reflection.glsl says what that must have). The renderer knows no representation by name.
#pragma once

#include <optional>
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
  /// Weights of basis BRDFs that it has, 0 to 4.
  virtual int weight_count() const { return 0; }
  /// What is drawn from now on is of the basis BRDF of this number, times its weight; unset: as if there were none.
  void set_basis(std::optional<int> number) { basis_ = number; }
  /// Lobes that a pixel's evaluations may be spent on, or on points (shaders/common/evaluations.glsl); 0: none.
  virtual int budgeted_lobes() const { return 0; }
  /// One normal a sample: an environment is sampled around it, by brute force.
  virtual bool samples_light() const { return false; }
  /// One texel a sample, drawn from those that the texture's filter takes at the pixel's middle: every sample looks
  /// there.
  virtual bool samples_footprint() const { return false; }

 protected:
  /// For shader_parts(): MULTUM_BASIS says which weight.
  void add_basis_flag(ShaderParts& parts) const {
    if (basis_) parts.flags.push_back("MULTUM_BASIS " + std::to_string(*basis_));
  }
  bool is_of_basis() const { return basis_.has_value(); }
  Material() = default;
  Material(Material&&) = default;

 private:
  std::optional<int> basis_;
};

}  // namespace multum::gl
