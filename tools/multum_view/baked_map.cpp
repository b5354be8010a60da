// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/baked_map.h"

#include <fmt/format.h>

#include "host/base/error.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"

namespace multum {

BakedMap read_baked_map(const std::string& path) {
  BakedMap map{read_baked_header(path), std::nullopt, std::nullopt};
  if (map.header.representation == Representation::kMovmf) map.lobes = read_movmf_mipmap(path);
  else map.moments = read_moment_mipmap(path);
  return map;
}

gl::NormalImage finest_normals(const BakedMap& map) {
  return map.lobes ? gl::finest_normals(*map.lobes) : gl::finest_normals(*map.moments);
}

std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map, const ViewOptions& options,
                                            const gl::NormalImage& source) {
  if (map.lobes) {
    auto material = std::make_unique<gl::MovmfMaterial>(gl, *map.lobes, options.anisotropy, &source);
    material->set_formula(options.formula);
    return material;
  }
  auto material = std::make_unique<gl::MomentMaterial>(gl, *map.moments, options.anisotropy, &source);
  material->set_shading(options.moments.value_or(kUsualMomentShading));
  return material;
}

void check_options_of(const ViewOptions& options, const BakedHeader& baked) {
  if (options.basis.size() > 1 && options.basis.size() != static_cast<std::size_t>(baked.weight_count))
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: holds {} weights, found {} of --brdf, expected one, or one a weight", options.input,
                            baked.weight_count, options.basis.size()));
  if (baked.has_roughness && options.has_brdf)
    throw Error(ErrorCode::kUsage,
                options.input + ": has its BRDF's width in (multum:roughness), found --brdf, expected none");
  if (baked.has_roughness && !options.environment.empty() && !options.compare.empty())
    throw Error(ErrorCode::kUsage, options.input +
                                       ": has its BRDF's width in, found --environment with --compare, "
                                       "expected lights: brute force knows one BRDF");
  if (baked.has_roughness && options.formula == gl::LobeFormula::kPaper)
    throw Error(ErrorCode::kUsage,
                options.input + ": has its BRDF's width in, found --formula paper, expected product");
  if (baked.has_roughness && !(options.compare.empty() || options.compare == std::vector<std::string>{"truth"}))
    throw Error(
        ErrorCode::kUsage,
        options.input + ": has its BRDF's width in, which the baselines know nothing of, expected --compare truth");
  const bool has_lobes = baked.representation == Representation::kMovmf;
  if (has_lobes && options.moments)
    throw Error(ErrorCode::kUsage, options.input + ": holds lobes, found --moments, expected it for files of moments");
  if (!has_lobes && options.formula == gl::LobeFormula::kPaper)
    throw Error(ErrorCode::kUsage, options.input + ": holds moments, found --formula paper, expected it for lobes");
}

}  // namespace multum
