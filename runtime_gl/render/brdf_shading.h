// SPDX-License-Identifier: Apache-2.0
// A BRDF in a shader: a file of shaders/brdf with its flag, and uniforms.
#pragma once

#include <map>
#include <vector>

#include <glm/vec3.hpp>

#include "host/brdf/brdf.h"
#include "runtime_gl/materials/material.h"
#include "runtime_gl/render/kept_of_brdf.h"

namespace multum::gl {

ShaderParts brdf_shader_parts(const Brdf& brdf);

class BrdfShading {
 public:
  /// `zonal_order`: that of the material (Material::zonal_order). Keeps what is fitted and integrated.
  void set(const ShaderProgram& shader, const Brdf& brdf, int zonal_order);

 private:
  struct Numbers {
    float exponent;
    glm::vec3 total;
    std::vector<glm::vec3> weights;               // of terms; none but for GGX and measurements
    std::vector<float> spreads;                   // as many
    std::map<int, std::vector<glm::vec3>> zonal;  // by order
  };
  static Numbers numbers_of(const Brdf& brdf);

  KeptOfBrdf<Numbers> kept_;
};

}  // namespace multum::gl
