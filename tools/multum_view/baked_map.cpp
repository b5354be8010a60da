// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/baked_map.h"

#include "host/base/error.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/sh_material.h"

namespace multum {

BakedMap read_baked_map(const std::string& path) {
  BakedMap map{read_baked_header(path), std::nullopt, std::nullopt, std::nullopt};
  switch (map.header.representation) {
    case Representation::kMovmf: map.lobes = read_movmf_mipmap(path); break;
    case Representation::kMoments: map.moments = read_moment_mipmap(path); break;
    case Representation::kSh: map.harmonics = read_sh_mipmap(path); break;
  }
  return map;
}

gl::NormalImage finest_normals(const BakedMap& map) {
  if (map.lobes) return gl::finest_normals(*map.lobes);
  return map.moments ? gl::finest_normals(*map.moments) : gl::finest_normals(*map.harmonics);
}

std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map, const ViewOptions& options,
                                            const gl::NormalImage& source) {
  if (map.lobes) {
    auto material = std::make_unique<gl::MovmfMaterial>(gl, *map.lobes, options.anisotropy, &source);
    material->set_formula(options.formula);
    return material;
  }
  if (map.harmonics) return std::make_unique<gl::ShMaterial>(gl, *map.harmonics, options.anisotropy, &source);
  auto material = std::make_unique<gl::MomentMaterial>(gl, *map.moments, options.anisotropy, &source);
  material->set_shading(options.moments.value_or(kUsualMomentShading));
  return material;
}

void check_options_of(const ViewOptions& options, const BakedHeader& baked) {
  const auto refuse = [&](const char* option, const char* expected) {
    const char* const held = baked.representation == Representation::kMovmf     ? "lobes"
                             : baked.representation == Representation::kMoments ? "moments"
                                                                                : "spherical harmonics";
    throw Error(ErrorCode::kUsage,
                options.input + ": holds " + held + ", found " + option + ", expected it for " + expected);
  };
  if (baked.representation != Representation::kMoments && options.moments) refuse("--moments", "files of moments");
  if (baked.representation != Representation::kMovmf && options.formula == gl::LobeFormula::kPaper)
    refuse("--formula paper", "lobes");
}

}  // namespace multum
