// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/baked_map.h"

#include <fmt/format.h>

#include "host/base/error.h"
#include "runtime_gl/materials/gmm_material.h"
#include "runtime_gl/materials/moment_material.h"

namespace multum {

BakedMap read_baked_map(const std::string& path) {
  BakedMap map{read_baked_header(path), std::nullopt, std::nullopt};
  if (holds_lobes(map.header.representation)) map.lobes = read_movmf_mipmap(path);
  else map.moments = read_moment_mipmap(path);
  return map;
}

gl::NormalImage finest_normals(const BakedMap& map) {
  return map.lobes ? gl::finest_normals(*map.lobes) : gl::finest_normals(*map.moments);
}

std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map, const ViewOptions& options,
                                            const gl::NormalImage& source) {
  if (map.lobes) {
    std::unique_ptr<gl::MovmfMaterial> material = make_lobe_material(gl, *map.lobes, options.anisotropy, &source);
    material->set_formula(options.formula);
    return material;
  }
  auto material = std::make_unique<gl::MomentMaterial>(gl, *map.moments, options.anisotropy, &source);
  material->set_shading(options.moments.value_or(kUsualMomentShading));
  return material;
}

namespace {

// Tan's model is of one BRDF, and of lights that come from somewhere.
void check_options_of_gaussians(const ViewOptions& options) {
  const auto refuse = [&](const char* found) {
    throw Error(ErrorCode::kUsage, fmt::format("{}: holds planar Gaussians, found {}, expected it for files of lobes "
                                               "(--ndf vmf) or harmonics (--ndf sh)",
                                               options.input, found));
  };
  if (options.scene.brdf.kind == BrdfKind::kGgx) refuse("--brdf ggx");
  if (options.scene.brdf.kind == BrdfKind::kMeasured) refuse("a measured --brdf");
  if (!options.environment.empty()) refuse("--environment");
  if (options.formula == gl::LobeFormula::kPaper) refuse("--formula paper");
}

}  // namespace

void check_options_of(const ViewOptions& options, const BakedHeader& baked) {
  const bool has_lobes = holds_lobes(baked.representation);
  if (baked.representation == Representation::kGmm) check_options_of_gaussians(options);
  if (has_lobes && options.moments)
    throw Error(ErrorCode::kUsage, options.input + ": holds lobes, found --moments, expected it for files of moments");
  if (!has_lobes && options.formula == gl::LobeFormula::kPaper)
    throw Error(ErrorCode::kUsage, options.input + ": holds moments, found --formula paper, expected it for lobes");
}

}  // namespace multum
