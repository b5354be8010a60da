// SPDX-License-Identifier: Apache-2.0
// Defines environments with known exact results, for the numerical cases of light/ and surface/.
#pragma once

#include <string>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "tests/gl/shader_harness.h"

namespace multum::gl {

/// Returns light/environment_levels.glsl with the texts that it needs, followed by `texts`.
ShaderHarnessInput environment_variant(const std::string& texts);

/// Makes a texture with `value` in every texel of every level.
Texture flat_texture(const GlFunctions& gl, const glm::vec4& value);

/// Grey light: L(l) = mean + linear . l + l . Q l, where the trace of Q is 0.
struct SmoothLight {
  double mean;
  glm::dvec3 linear;

  static glm::dmat3 quadratic();
  /// Integrates L(l) max(n . l, 0) by quadrature.
  double irradiance(const glm::dvec3& n) const;
};

void set_smooth_light(const ShaderProgram& program, const SmoothLight& light);

constexpr int kLevelCount = 5;
constexpr float kLevelSpreads[kLevelCount] = {1e-3f, 1e-2f, 0.1f, 0.5f, 0.9f};

/// Sets the uniforms for the levels and for one term of the facets.
void set_levels(const ShaderProgram& program);

/// Describes light that is equal from every direction, and a surface that reflects the fraction highlight() / radiance
/// of this light.
class ConstantLight {
 public:
  explicit ConstantLight(const GlFunctions& gl);
  void set(const ShaderProgram& program) const;

  static glm::dvec3 irradiance();
  static glm::dvec3 highlight();

 private:
  Texture map_, table_;
};

}  // namespace multum::gl
