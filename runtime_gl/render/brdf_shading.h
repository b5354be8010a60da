// SPDX-License-Identifier: Apache-2.0
// Defines a BRDF in a shader. It needs the files of shaders/brdf with the BRDF's flag, its uniforms, and the table for
// GGX.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <vector>

#include <glm/vec3.hpp>

#include "host/formats/brdf/brdf.h"
#include "runtime_gl/gl/texture.h"
#include "runtime_gl/materials/material.h"
#include "runtime_gl/render/kept_of_brdf.h"
#include "runtime_gl/render/scene.h"

namespace multum::gl {

ShaderParts brdf_shader_parts(const Brdf& brdf);

class BrdfShading {
 public:
  explicit BrdfShading(const GlFunctions& gl) : gl_(gl) {}

  /// `zonal_order` is the material's order (Material::zonal_order). Uses texture units from `first_unit` on and returns
  /// the next free one. Caches fits and integrals.
  int set(const ShaderProgram& shader, const Brdf& brdf, const std::shared_ptr<const RoughnessMap>& roughness,
          int zonal_order, int first_unit);

 private:
  struct Numbers {
    float exponent;
    glm::vec3 total;
    std::vector<glm::vec3> weights;               // weights of the terms, if the shader uses these
    std::vector<float> spreads;                   // one per weight
    std::map<int, std::vector<glm::vec3>> zonal;  // coefficients by order
  };
  static Numbers numbers_of(const Brdf& brdf);
  void set_roughness(const std::shared_ptr<const RoughnessMap>& map);

  const GlFunctions& gl_;
  KeptOfBrdf<Numbers> kept_;
  std::optional<Texture> ggx_lobes_;
  std::shared_ptr<const RoughnessMap> roughness_map_;
  std::optional<Texture> roughness_;  // texture of `roughness_map_`
};

}  // namespace multum::gl
