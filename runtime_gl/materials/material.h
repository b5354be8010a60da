// SPDX-License-Identifier: Apache-2.0
// Defines the material of a surface, which consists of the textures of one representation of its normals, and the GLSL
// that reads them. shaders/common/reflection.glsl lists the functions that this GLSL must define. The renderer does not
// depend on any representation.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "runtime_gl/gl/shader_program.h"

namespace multum::gl {

/// The GLSL of a shader's variant. Each flag becomes one #define, and the texts follow one another.
struct ShaderParts {
  std::vector<std::string> flags;
  std::vector<const char*> texts;  // texts from embedded_shaders.h
};

class Material {
 public:
  virtual ~Material() = default;
  /// Returns the name used in messages, such as "movmf".
  virtual const char* name() const = 0;
  /// Returns the file of surface/, preceded by the files of common/ and brdf/ that it needs.
  virtual ShaderParts shader_parts() const = 0;
  /// Binds textures to units from 0 on, assigns these units to the shader's samplers, and sets the material's uniforms.
  /// Returns the first free unit.
  virtual int bind(const ShaderProgram& shader) const = 0;
  /// Returns the highest order of the BRDF's zonal coefficients (u_zonal) that the surface uses, or -1 if it uses none.
  virtual int zonal_order() const { return -1; }
  /// Returns the number of the material's blend weights of basis BRDFs, 0 to 4.
  virtual int weight_count() const { return 0; }
  /// From now on, draws only the basis BRDF with this number, multiplied by its weight. If unset, ignores the weights.
  void set_basis(std::optional<int> number) { basis_ = number; }
  /// Returns the number of lobes among which a pixel's evaluations can be divided (shaders/common/evaluations.glsl), or
  /// 0 if they can only be divided among points.
  virtual int budgeted_lobes() const { return 0; }
  /// Returns whether each sample has one normal, around which an environment is sampled by brute force.
  virtual bool samples_light() const { return false; }
  /// Returns whether each sample uses one texel, drawn at random from the texels that the texture filter reads at the
  /// middle of the pixel. If so, samples are not shifted within the pixel.
  virtual bool samples_footprint() const { return false; }

 protected:
  /// Adds MULTUM_BASIS, the number of the weight, for shader_parts().
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
