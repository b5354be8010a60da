// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/brdf_shading.h"

#include <glm/gtc/type_ptr.hpp>

#include "host/brdf/facet_distribution.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {

ShaderParts brdf_shader_parts(const Brdf& brdf) {
  switch (brdf.kind) {
    case BrdfKind::kBlinnPhong: return {{"MULTUM_BLINN_PHONG"}, {shader_brdf_blinn_phong_glsl}};
    case BrdfKind::kTorranceSparrow: return {{"MULTUM_TORRANCE_SPARROW"}, {shader_brdf_torrance_sparrow_glsl}};
  }
  return {};
}

void set_brdf(const ShaderProgram& shader, const Brdf& brdf, int zonal_order) {
  shader.set_vec3("u_diffuse", glm::value_ptr(brdf.diffuse), 1);
  shader.set_vec3("u_specular", glm::value_ptr(brdf.specular), 1);
  shader.set("u_exponent", static_cast<float>(equivalent_exponent(brdf)));
  shader.set("u_sigma", brdf.sigma);
  if (zonal_order < 0) return;
  std::vector<glm::vec3> zonal;
  for (const glm::dvec3& coefficient : zonal_coefficients(brdf, zonal_order)) zonal.emplace_back(coefficient);
  shader.set_vec3("u_zonal", glm::value_ptr(zonal[0]), zonal_order + 1);
}

}  // namespace multum::gl
