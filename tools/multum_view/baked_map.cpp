// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_view/baked_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "host/formats/asset/pyramid/pyramid_file.h"
#include "host/foundation/base/error.h"
#include "runtime_gl/materials/gmm_material.h"
#include "runtime_gl/materials/moment_material.h"
#include "runtime_gl/materials/movmf_material.h"
#include "runtime_gl/materials/sh_material.h"
#include "runtime_gl/pyramid/pyramid_renderer.h"

namespace multum {

namespace {

// Reads the levels of one representation into its type in memory. The table has one row per representation.
struct LevelReader {
  Representation representation;
  BakedLevels (*read)(const std::string& path);
};

constexpr BakedLevels (*kReadLobes)(const std::string&) = [](const std::string& path) -> BakedLevels {
  return read_movmf_mipmap(path);
};
constexpr LevelReader kLevelReaders[] = {
    {Representation::kMovmf, kReadLobes},
    {Representation::kGmm, kReadLobes},
    {Representation::kMoments, [](const std::string& path) -> BakedLevels { return read_moment_mipmap(path); }},
    {Representation::kSh, [](const std::string& path) -> BakedLevels { return read_sh_mipmap(path); }}};

BakedLevels read_levels(const std::string& path, Representation representation) {
  const auto* const reader = std::find_if(std::begin(kLevelReaders), std::end(kLevelReaders),
                                          [&](const LevelReader& row) { return row.representation == representation; });
  MULTUM_CHECK(reader != std::end(kLevelReaders));
  return reader->read(path);
}

template <typename Level>
void drop_left_out(std::vector<Level>& levels, int first_level) {
  levels.erase(levels.begin(), levels.begin() + first_level);
}

template <typename Mipmap>
void keep_stored(Mipmap& map) {
  BakedHeader& header = map.header;
  drop_left_out(map.levels, header.first_level);
  header.width = mip_level_size(header.width, header.first_level);
  header.height = mip_level_size(header.height, header.first_level);
  header.first_level = 0;
}

/// Makes the material of each representation.
struct MaterialMaker {
  const gl::GlFunctions& gl;
  const ShadingOptions& options;
  const gl::NormalImage& source;
  const LobeTexture* texture;  // if null, the lobes come from the baked file

  std::unique_ptr<gl::Material> operator()(const MovmfMipmap& lobes) const {
    std::unique_ptr<gl::MovmfMaterial> material = make_lobe_material(gl, lobes, options.anisotropy, &source);
    if (texture != nullptr) material->set_layers(gl, *texture, options.anisotropy);
    material->set_formula(options.formula);
    material->set_shade_first(options.shade_first);
    const bool can_be_magnified = lobes.header.first_level == 0 && !lobes.header.has_roughness;
    material->set_magnified(can_be_magnified && options.surface == MapSurface::kInterpolated);
    if (!options.colour_map.empty())
      material->set_mean_colours(gl::make_pyramid_texture(gl, read_pyramid(options.colour_map, PyramidKind::kColour),
                                                          gl::PyramidLookup::kDriver, options.anisotropy));
    return material;
  }
  std::unique_ptr<gl::Material> operator()(const MomentMipmap& moments) const {
    auto material = std::make_unique<gl::MomentMaterial>(gl, moments, options.anisotropy, &source);
    material->set_shading(options.moments.value_or(kDefaultMomentShading));
    return material;
  }
  std::unique_ptr<gl::Material> operator()(const ShMipmap& harmonics) const {
    return std::make_unique<gl::ShMaterial>(gl, harmonics, options.anisotropy, &source);
  }
};

}  // namespace

BakedMap read_baked_map(const std::string& path) {
  if (is_ktx2_file(path)) {
    LobeTexture texture = read_lobe_texture(path);
    MovmfMipmap lobes = unpacked_mipmap(texture);
    BakedHeader header = lobes.header;
    return {std::move(header), std::move(lobes), std::move(texture)};
  }
  BakedHeader header = read_baked_header(path);
  const Representation representation = header.representation;
  return {std::move(header), read_levels(path, representation)};
}

void keep_stored_levels(BakedMap& map) {
  std::visit([](auto& levels) { keep_stored(levels); }, map.levels);
}

gl::NormalImage finest_normals(const BakedMap& map) {
  return std::visit([](const auto& levels) { return gl::finest_normals(levels); }, map.levels);
}

std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map,
                                            const ShadingOptions& options, const gl::NormalImage& source) {
  return std::visit(MaterialMaker{gl, options, source, map.texture ? &*map.texture : nullptr}, map.levels);
}

namespace {

// Tan's model supports only one BRDF. It supports lights, but no environment.
void check_options_of_gaussians(const std::string& file, const PictureOptions& options, const Brdf& brdf) {
  const auto refuse = [&](const std::string& found) {
    throw Error(ErrorCode::kUsage, fmt::format("{}: holds planar Gaussians, which do not support {}; expected a file "
                                               "of lobes (--ndf vmf) or harmonics (--ndf sh)",
                                               file, found));
  };
  const BrdfFamily& family = family_of(brdf);
  if (is_vmf_sum(brdf)) refuse(family.is_file ? "a measured --brdf" : fmt::format("--brdf {}", family.name));
  if (!options.light.environment.empty()) refuse("--environment");
  if (options.shading.formula == gl::LobeFormula::kPaper) refuse("--formula paper");
}

// A map that was baked with roughness stores the BRDF's width per texel. The brute-force method and the paper's formula
// support only one BRDF for the whole map.
void check_options_of_roughness(const std::string& file, const PictureOptions& options, bool compares) {
  if (!options.material.brdfs.empty())
    throw Error(
        ErrorCode::kUsage,
        file + ": was baked with roughness (multum:roughness), which defines the BRDF; found --brdf, expected none");
  if (!options.light.environment.empty() && compares)
    throw Error(ErrorCode::kUsage,
                file +
                    ": was baked with roughness; found --environment with --compare, expected lights instead of an "
                    "environment, because the reference supports only one BRDF under an environment");
  if (options.shading.formula == gl::LobeFormula::kPaper)
    throw Error(ErrorCode::kUsage, file + ": was baked with roughness; found --formula paper, expected product");
}

}  // namespace

void check_options_of(const std::string& file, const PictureOptions& options, const ViewScenes& scenes, bool compares,
                      const BakedHeader& baked) {
  const ShadingOptions& shading = options.shading;
  if (scenes.basis.size() > 1 && scenes.basis.size() != static_cast<std::size_t>(baked.weight_count))
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: holds {} weights, but --brdf was given {} times; give it once, or once per weight",
                            file, baked.weight_count, scenes.basis.size()));
  if (baked.has_roughness) check_options_of_roughness(file, options, compares);
  const RepresentationInfo& info = representation_info(baked.representation);
  const auto refuse = [&](const char* option, const char* expected) {
    throw Error(ErrorCode::kUsage, fmt::format("{}: holds {}, but {} needs {}", file, info.contents, option, expected));
  };
  if (info.lobes == nullptr && !shading.colour_map.empty()) refuse("--colour-map", "files of lobes");
  if (baked.has_colours && !shading.colour_map.empty())
    throw Error(ErrorCode::kUsage,
                file + ": contains colours, and --colour-map was given too; expected only one of them");
  const bool has_highlight =
      scenes.first.brdf.kind != BrdfKind::kLambert || scenes.last.brdf.kind != BrdfKind::kLambert;
  if (info.has_order && !options.light.environment.empty() && !baked.has_roughness && has_highlight &&
      scenes.first.environment_mode != gl::EnvironmentMode::kHarmonics)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: holds {}, whose highlights need the harmonics of the environment; found "
                            "--environment-mode prefiltered, expected sh",
                            file, info.contents));
  if (!info.takes_every_brdf) check_options_of_gaussians(file, options, scenes.first.brdf);
  if (!info.has_slopes && shading.moments) refuse("--moments", "files of moments");
  if (!info.has_kappa && shading.formula == gl::LobeFormula::kPaper) refuse("--formula paper", "lobes");
  if (info.lobes == nullptr && shading.shade_first) refuse("--shade-first", "lobes");
  if (shading.shade_first && baked.first_level > 0)
    refuse("--shade-first", "a file that holds every level, baked without --first-level");
}

std::string environment_note(const MapOptions& options, const BakedHeader& baked) {
  const std::vector<std::string>& compared = options.comparison.pictures;
  const bool compares_lean =
      std::any_of(compared.begin(), compared.end(), [](const std::string& name) { return name.starts_with("lean"); });
  const bool draws_lean =
      representation_info(baked.representation).has_slopes &&
      options.picture.shading.moments.value_or(kDefaultMomentShading) != gl::MomentShading::kToksvig;
  if (options.picture.light.environment.empty()) return "";
  if (representation_info(baked.representation).has_order && baked.has_roughness)
    return "--environment: highlights of harmonics that include roughness are drawn with one lobe around the mean "
           "normal";
  if (!compares_lean && !draws_lean) return "";
  return "--environment: under this light, lean and lean-jacobian are drawn in the same way as toksvig, with one lobe "
         "around the mean normal";
}

}  // namespace multum
