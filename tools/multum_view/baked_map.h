// SPDX-License-Identifier: Apache-2.0
// Reads a baked file of any representation, makes the material that draws it, and checks options that only some
// representations support. A new representation needs an alternative in BakedLevels, and overloads for the visitors of
// BakedLevels.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/textures/lobe_texture.h"
#include "runtime_gl/materials/normal_material.h"
#include "tools/multum_view/view_scenes.h"

namespace multum {

using BakedLevels = std::variant<MovmfMipmap, MomentMipmap, ShMipmap>;  // lobes, moments, harmonics

struct BakedMap {
  BakedHeader header;  // as stored in the file
  BakedLevels levels;
  std::optional<LobeTexture> texture = std::nullopt;  // the texture from which the levels were unpacked
};

BakedMap read_baked_map(const std::string& path);
/// Keeps only the stored levels, as if the map had no finer levels. Does not change BakedMap::header.
void keep_stored_levels(BakedMap& map);

/// Returns level 0 as normals. Level 0 must be stored.
gl::NormalImage finest_normals(const BakedMap& map);

/// Makes a material that shades according to the options. Levels that are missing in the file are taken from `source`.
std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map,
                                            const ShadingOptions& options, const gl::NormalImage& source);

/// Throws Error(kUsage) that names `file` if an option applies only to files of another representation. `compares` is
/// true if --compare was given.
void check_options_of(const std::string& file, const PictureOptions& options, const ViewScenes& scenes, bool compares,
                      const BakedHeader& baked);

/// Returns a note if an environment lights moments, LEAN maps or harmonics that include roughness, whose highlights are
/// then those of one lobe around the mean normal. Otherwise returns an empty string.
std::string environment_note(const MapOptions& options, const BakedHeader& baked);

/// The default shading for files of moments. In measured bakes, it has the lowest error on most maps
/// (docs/contributing/ALGORITHMS.md, "Moments").
constexpr gl::MomentShading kDefaultMomentShading = gl::MomentShading::kLeanJacobian;

}  // namespace multum
