// SPDX-License-Identifier: Apache-2.0
// Reads a baked file of any representation, makes what draws it, and checks the options that are for it alone. A new
// representation is an alternative of BakedLevels and an overload where its visitors need one.
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
  BakedHeader header;  // as the file has it
  BakedLevels levels;
  std::optional<LobeTexture> texture = std::nullopt;  // what levels were unpacked from
};

BakedMap read_baked_map(const std::string& path);
/// The levels that are stored, as if the map had no finer ones; the header stays.
void keep_stored_levels(BakedMap& map);

/// Level 0, which must be stored, as normals.
gl::NormalImage finest_normals(const BakedMap& map);

/// Shaded as the options say. `source`: used where the file leaves levels to it.
std::unique_ptr<gl::Material> make_material(const gl::GlFunctions& gl, const BakedMap& map,
                                            const ShadingOptions& options, const gl::NormalImage& source);

/// Throws Error(kUsage) naming `file`: an option is for files of another representation. `compares`: --compare is
/// given.
void check_options_of(const std::string& file, const PictureOptions& options, const ViewScenes& scenes, bool compares,
                      const BakedHeader& baked);

/// A line where moments and LEAN are drawn in an environment, which sees no more of them than of Toksvig's normals;
/// else empty.
std::string environment_note(const MapOptions& options, const BakedHeader& baked);

/// Of files of moments, when no option says it: the one of least error on most maps, by the bakes' own measurements
/// (docs/contributing/ALGORITHMS.md, "Moments").
constexpr gl::MomentShading kDefaultMomentShading = gl::MomentShading::kLeanJacobian;

}  // namespace multum
