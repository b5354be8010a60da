// SPDX-License-Identifier: Apache-2.0
#include "runtime_gl/render/brdf_shading.h"

#include <glm/gtc/type_ptr.hpp>

#include "host/formats/asset/baked_file.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/fresnel.h"
#include "host/formats/brdf/measured_brdf.h"
#include "host/formats/brdf/vmf_terms.h"
#include "runtime_gl/materials/ggx_lobe_texture.h"
#include "runtime_gl/materials/mip_texture.h"
#include "runtime_gl/materials/texture_binder.h"
#include "runtime_gl/shaders/embedded_shaders.h"

namespace multum::gl {
namespace {

std::vector<glm::vec3> to_floats(const std::vector<glm::dvec3>& values) { return {values.begin(), values.end()}; }

ShaderParts parts_of_family(const Brdf& brdf) {
  const BrdfFamily& family = family_of(brdf);
  ShaderParts parts{{family.shader_flags.begin(), family.shader_flags.end()}, {}};
  if (family.shader_takes_terms) parts.flags.push_back("MULTUM_TERM_COUNT " + std::to_string(brdf.term_count));
  for (const std::string_view file : family.shader_files) parts.texts.push_back(brdf_shader_text(file));
  return parts;
}

}  // namespace

ShaderParts brdf_shader_parts(const Brdf& brdf) {
  ShaderParts parts = parts_of_family(brdf);
  if (brdf.fixed_fresnel) return parts;
  if (has_fresnel(brdf)) parts.flags.push_back("MULTUM_FRESNEL");
  if (has_diffuse_fresnel(brdf)) parts.flags.push_back("MULTUM_FRESNEL_DIFFUSE");
  return parts;
}

BrdfShading::Numbers BrdfShading::numbers_of(const Brdf& brdf) {
  Numbers numbers{static_cast<float>(equivalent_exponent(brdf)), glm::vec3(facet_total(brdf)), {}, {}, {}};
  if (!family_of(brdf).shader_takes_terms) return numbers;
  for (const VmfTerm& term : vmf_terms(brdf)) {
    numbers.weights.emplace_back(term.weight);
    numbers.spreads.push_back(static_cast<float>(term.spread));
  }
  return numbers;
}

void BrdfShading::set_roughness(const std::shared_ptr<const RoughnessMap>& map) {
  if (roughness_map_ == map) return;
  roughness_map_ = map;
  roughness_.reset();
  TexelPlane plane{map->width, map->height, {}};
  for (const float value : map->texels) plane.texels.emplace_back(value, 0.0f, 0.0f, 1.0f);
  roughness_.emplace(upload_mips(gl_, "the BRDF's roughness", std::move(plane),
                                 mip_level_count(map->width, map->height), {map->wrap_s, map->wrap_t, true, 1.0f}));
}

int BrdfShading::set(const ShaderProgram& shader, const Brdf& brdf,
                     const std::shared_ptr<const RoughnessMap>& roughness, int zonal_order, int first_unit) {
  Numbers& numbers = kept_.of(brdf, numbers_of);
  const glm::vec3 fixed = has_fresnel(brdf) ? brdf.fixed_fresnel.value_or(glm::vec3(1.0f)) : glm::vec3(1.0f);
  const bool dims_diffuse = brdf.fixed_fresnel && has_diffuse_fresnel(brdf);
  const glm::vec3 diffuse = brdf.diffuse * (dims_diffuse ? 1.0f - fixed : glm::vec3(1.0f));
  const glm::vec3 specular = brdf.specular * fixed;
  shader.set_vec3("u_diffuse", glm::value_ptr(diffuse), 1);
  shader.set_vec3("u_specular", glm::value_ptr(specular), 1);
  shader.set("u_exponent", numbers.exponent);
  shader.set_vec3("u_facet_total", glm::value_ptr(numbers.total), 1);
  shader.set("u_sigma", brdf.sigma);
  shader.set("u_alpha", ggx_alpha(brdf));
  shader.set_vec3("u_f0", glm::value_ptr(brdf.f0), 1);
  if (!numbers.weights.empty()) {
    const int count = static_cast<int>(numbers.weights.size());
    shader.set_vec3("u_term_weights", glm::value_ptr(numbers.weights[0]), count);
    shader.set_floats("u_term_spreads", numbers.spreads.data(), count);
  }
  if (brdf.kind == BrdfKind::kMeasured) {
    const std::vector<glm::vec3> facets = to_floats(brdf.measured->facets);
    const std::vector<float> differences(brdf.measured->differences.begin(), brdf.measured->differences.end());
    shader.set_vec3("u_facets", glm::value_ptr(facets[0]), kFacetTableSize);
    shader.set_floats("u_differences", differences.data(), kDifferenceTableSize);
  }
  TextureBinder binder(shader, first_unit);
  if (brdf.kind == BrdfKind::kGgx) {
    if (!ggx_lobes_) ggx_lobes_.emplace(make_ggx_lobe_texture(gl_));
    binder.bind("u_ggx_lobe_table", ggx_lobes_);
    if (roughness != nullptr) {
      set_roughness(roughness);
      binder.bind("u_roughness_texture", roughness_);
    }
  }
  if (zonal_order < 0) return binder.next_unit();
  std::vector<glm::vec3>& zonal = numbers.zonal[zonal_order];
  if (zonal.empty()) zonal = to_floats(zonal_coefficients(brdf, zonal_order));
  shader.set_vec3("u_zonal", glm::value_ptr(zonal[0]), zonal_order + 1);
  return binder.next_unit();
}

}  // namespace multum::gl
