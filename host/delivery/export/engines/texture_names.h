// SPDX-License-Identifier: Apache-2.0
// Names the textures of an exported material by the habits of engines.
#pragma once

#include <string>

#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

enum class TextureRole {
  kNormal,
  kOrm,        // occlusion, roughness, metalness, for glTF and Unreal
  kMask,       // metalness, occlusion, 1, smoothness, for Unity
  kRoughness,  // this role and the next three have one channel
  kSmoothness,
  kOcclusion,
  kMetalness,
  kAnisotropy,  // direction x and y, strength, for KHR_materials_anisotropy
};

/// Returns the plain name of a texture, such as "normal".
const char* name_of(TextureRole role);

/// Returns the file name of a texture without level and extension, such as T_rock_N for the material "rock" and
/// TextureNames::kUnreal. Only plain names may lack a material.
std::string texture_name(TextureNames names, const std::string& material, TextureRole role);

/// Returns the material that the file of a normal map or height field names: "rock" for maps/rock_normal.png and
/// T_Rock_N.tga. A name that consists only of such a word remains whole.
std::string material_of_file(const std::string& path);

}  // namespace multum
