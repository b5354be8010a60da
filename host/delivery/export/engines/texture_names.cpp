// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/engines/texture_names.h"

#include <algorithm>
#include <cctype>
#include <filesystem>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

// The words of a texture in the habit of each engine.
// plain: O3DE's image builder (PresetsByFileMask in Gems/Atom/Asset/ImageProcessingAtom/Assets/Config/
// ImageBuilder.settings) and Blender's Node Wrangler recognise these words.
// unreal: the prefix T_ is Epic's; the suffixes are the habit of its users. Unreal itself ignores both.
// unity: the names that Adobe's presets use. Unity itself ignores them.
struct Words {
  TextureRole role;
  const char *plain, *unreal, *unity;
};
constexpr Words kWords[] = {{TextureRole::kNormal, "normal", "N", "Normal"},
                            {TextureRole::kOrm, "orm", "ORM", "ORM"},
                            {TextureRole::kMask, "mask", "Mask", "MaskMap"},
                            {TextureRole::kRoughness, "roughness", "R", "Roughness"},
                            {TextureRole::kSmoothness, "smoothness", "Smoothness", "Smoothness"},
                            {TextureRole::kOcclusion, "ao", "AO", "Occlusion"},
                            {TextureRole::kMetalness, "metallic", "M", "Metallic"},
                            {TextureRole::kAnisotropy, "anisotropy", "Anisotropy", "Anisotropy"}};

const Words& words_of(TextureRole role) {
  for (const Words& words : kWords)
    if (words.role == role) return words;
  MULTUM_CHECK(false);
}

// The ends of names of normal maps and height fields.
constexpr const char* kEnds[] = {"normalmap", "normals", "normal",    "nrm",  "norm", "nor", "nml",
                                 "bump",      "height",  "heightmap", "disp", "n",    "h"};

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

}  // namespace

const char* name_of(TextureRole role) { return words_of(role).plain; }

std::string texture_name(TextureNames names, const std::string& material, TextureRole role) {
  MULTUM_CHECK(names == TextureNames::kPlain || !material.empty());
  const Words& words = words_of(role);
  switch (names) {
    case TextureNames::kPlain: return (material.empty() ? "" : material + "_") + words.plain;
    case TextureNames::kUnreal: return "T_" + material + "_" + words.unreal;
    case TextureNames::kUnity: return material + "_" + words.unity;
  }
  MULTUM_CHECK(false);
}

std::string material_of_file(const std::string& path) {
  std::string name = std::filesystem::path(path).filename().string();
  name = name.substr(0, name.find('.'));
  const std::size_t end = name.find_last_of("_-");
  if (end != std::string::npos && end > 0 &&
      std::find(std::begin(kEnds), std::end(kEnds), lower(name.substr(end + 1))) != std::end(kEnds))
    name.resize(end);
  if (name.starts_with("T_") && name.size() > 2) name.erase(0, 2);
  return name.empty() ? "material" : name;
}

}  // namespace multum
