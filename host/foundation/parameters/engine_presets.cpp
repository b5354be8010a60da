// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/engine_presets.h"

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

using enum MaterialTexels;
using enum MaterialPacking;
using enum SideRule;
constexpr GreenAxis kUp = GreenAxis::kUp, kDown = GreenAxis::kDown;
constexpr MaterialFormat kKtx2 = MaterialFormat::kKtx2, kDds = MaterialFormat::kDds, kPng = MaterialFormat::kPng;
using Names = TextureNames;
using Gltf = GltfTextureFormat;

// Columns: format, texels, green, packing, names, sides, Zstandard level, format of `multum gltf`, note.
constexpr EnginePreset kPresets[] = {
    {Engine::kThree, "three.js", "web_engines", kKtx2, kRgba8, kUp, kOrm, Names::kPlain, kAny, 15, Gltf::kAuto},
    {Engine::kBabylon, "Babylon.js", "web_engines", kKtx2, kUastc, kUp, kOrm, Names::kPlain, kMultiplesOf4, 0,
     Gltf::kUastc},
    {Engine::kPlayCanvas, "PlayCanvas", "web_engines", kKtx2, kUastc, kUp, kOrm, Names::kPlain, kMultiplesOf4, 0,
     Gltf::kUastc},
    {Engine::kFilament, "Filament", "web_engines", kKtx2, kUastc, kUp, kOrm, Names::kPlain, kMultiplesOf4, 0,
     Gltf::kUastc},
    {Engine::kGodot, "Godot", "godot", kDds, kBlocks, kUp, kOrm, Names::kPlain, kPowersOf2, 0, Gltf::kUastc},
    // Unity imports BC7 upside down.
    {Engine::kUnity, "Unity", "unity", kDds, kRgba8, kUp, kMask, Names::kUnity, kAny, 0, Gltf::kUastc},
    {Engine::kUnityHdrp, "Unity HDRP", "unity", kDds, kRgba8, kUp, kMask, Names::kUnity, kAny, 0, Gltf::kUastc},
    // Unreal imports no blocks, and compresses each stored level itself.
    {Engine::kUnreal, "Unreal", "unreal", kDds, kRgba8, kDown, kOrm, Names::kUnreal, kPowersOf2},
    {Engine::kO3de, "O3DE", "o3de", kDds, kRgba8, kDown, kSeparate, Names::kPlain, kPowersOf2, 0, Gltf::kPng,
     "O3DE keeps only level 0, and makes its own mips"},
    {Engine::kBlender, "Blender", "blender", kPng, kRgba8, kUp, kSeparate, Names::kPlain, kAny, 0, Gltf::kPng,
     "materials use level 0, unless a script selects levels"},
};

}  // namespace

const EnginePreset& preset_of(Engine engine) {
  for (const EnginePreset& preset : kPresets)
    if (preset.engine == engine) return preset;
  MULTUM_CHECK(false);
}

std::string packing_text(MaterialPacking packing) {
  switch (packing) {
    case kOrm: return "roughness in green of orm";
    case kMask: return "smoothness in alpha of mask";
    case kSeparate: return "one texture per map";
    case kSmoothness: return "one texture per map, smoothness instead of roughness";
  }
  MULTUM_CHECK(false);
}

std::string preset_text(const EnginePreset& preset) {
  std::string text = fmt::format("{}, {}, green {}, {}", choice_name(kMaterialFormats, preset.format),
                                 choice_name(kMaterialTexels, preset.texels), choice_name(kGreenAxes, preset.green),
                                 choice_name(kMaterialPackings, preset.packing));
  if (preset.sides != kAny) text += fmt::format(", sides {}", choice_name(kSideRules, preset.sides));
  if (*preset.note != '\0') text += fmt::format("; {}", preset.note);
  return text;
}

}  // namespace multum
