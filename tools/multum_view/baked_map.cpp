// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/baked_map.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/asset/pyramid/pyramid_file.h"
#include "host/base/error.h"
#include "runtime_gl/materials/gmm_material.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/pyramid/pyramid_renderer.h"

namespace multum {

BakedMap read_baked_map(const std::string& path) {
  BakedMap map{read_baked_header(path), std::nullopt, std::nullopt, std::nullopt};
  switch (map.header.representation) {
    case Representation::kMovmf:
    case Representation::kGmm: map.lobes = read_movmf_mipmap(path); break;
    case Representation::kMoments: map.moments = read_moment_mipmap(path); break;
    case Representation::kSh: map.harmonics = read_sh_mipmap(path); break;
  }
  return map;
}

namespace {

template <typename Level>
void drop_left_out(std::vector<Level>& levels, int first_level) {
  levels.erase(levels.begin(), levels.begin() + first_level);
}

void begin_at_first_level(BakedHeader& header) {
  header.width = mip_level_size(header.width, header.first_level);
  header.height = mip_level_size(header.height, header.first_level);
  header.first_level = 0;
}

}  // namespace

void keep_stored_levels(BakedMap& map) {
  if (map.lobes) {
    drop_left_out(map.lobes->levels, map.lobes->header.first_level);
    map.lobes->header.first_level = 0;
  } else if (map.moments) {
    drop_left_out(map.moments->levels, map.moments->header.first_level);
    begin_at_first_level(map.moments->header);
  } else {
    drop_left_out(map.harmonics->levels, map.harmonics->header.first_level);
    begin_at_first_level(map.harmonics->header);
  }
}

gl::NormalImage finest_normals(const BakedMap& map) {
  if (map.lobes) return gl::finest_normals(*map.lobes);
  return map.moments ? gl::finest_normals(*map.moments) : gl::finest_normals(*map.harmonics);
}

std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map, const ViewOptions& options,
                                            const gl::NormalImage& source) {
  if (map.lobes) {
    std::unique_ptr<gl::MovmfMaterial> material = make_lobe_material(gl, *map.lobes, options.anisotropy, &source);
    material->set_formula(options.formula);
    material->set_shade_first(options.shade_first);
    if (!options.colour_map.empty())
      material->set_mean_colours(gl::make_pyramid_texture(gl, read_pyramid(options.colour_map, PyramidKind::kColour),
                                                          gl::PyramidLookup::kDriver, options.anisotropy));
    return material;
  }
  if (map.harmonics) return std::make_unique<gl::ShMaterial>(gl, *map.harmonics, options.anisotropy, &source);
  auto material = std::make_unique<gl::MomentMaterial>(gl, *map.moments, options.anisotropy, &source);
  material->set_shading(options.moments.value_or(kDefaultMomentShading));
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
  const auto refuse = [&](const char* option, const char* expected) {
    const char* const held = holds_lobes(baked.representation)                  ? "lobes"
                             : baked.representation == Representation::kMoments ? "moments"
                                                                                : "spherical harmonics";
    throw Error(ErrorCode::kUsage,
                options.input + ": holds " + held + ", found " + option + ", expected it for " + expected);
  };
  if (!holds_lobes(baked.representation) && !options.colour_map.empty()) refuse("--colour-map", "files of lobes");
  if (baked.has_colours && !options.colour_map.empty())
    throw Error(ErrorCode::kUsage, options.input + ": has colours, found --colour-map, expected one of them");
  if (baked.representation == Representation::kGmm) check_options_of_gaussians(options);
  if (baked.representation != Representation::kMoments && options.moments) refuse("--moments", "files of moments");
  if (baked.representation != Representation::kMovmf && options.formula == gl::LobeFormula::kPaper)
    refuse("--formula paper", "lobes");
  if (!holds_lobes(baked.representation) && options.shade_first) refuse("--shade-first", "lobes");
  if (options.shade_first && baked.first_level > 0)
    refuse("--shade-first", "files that hold every level, baked without --first-level");
}

std::string environment_note(const ViewOptions& options, const BakedHeader& baked) {
  const bool compares_lean = std::any_of(options.compare.begin(), options.compare.end(),
                                         [](const std::string& name) { return name.starts_with("lean"); });
  const bool draws_lean = baked.representation == Representation::kMoments &&
                          options.moments.value_or(kDefaultMomentShading) != gl::MomentShading::kToksvig;
  if (options.environment.empty() || (!compares_lean && !draws_lean)) return "";
  return "--environment: lean and lean-jacobian are the same as toksvig in its light, one lobe of the mean normal";
}

}  // namespace multum
