// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/engines/engine_support.h"

namespace multum {

std::vector<std::string> engines_that_fail(MaterialFormat format, MaterialTexels texels) {
  switch (format) {
    case MaterialFormat::kPng:
    case MaterialFormat::kExr: return {};
    case MaterialFormat::kKtx2:
      if (texels == MaterialTexels::kUastc) return {"Unreal", "O3DE", "Godot 3", "Blender"};
      return {"Babylon.js", "PlayCanvas", "Filament", "Unreal", "O3DE", "Godot 3", "Blender"};
    case MaterialFormat::kDds: break;
  }
  // These engines cannot load DDS files with a DX10 header.
  if (texels == MaterialTexels::kRgba16f) return {"three.js", "PlayCanvas", "Filament", "Godot 3", "Blender"};
  if (texels == MaterialTexels::kBlocks)
    return {"three.js", "Babylon.js", "PlayCanvas", "Filament", "Unreal", "Godot 3"};
  if (texels == MaterialTexels::kRg8)
    return {"three.js", "Babylon.js", "PlayCanvas", "Filament", "Unreal", "Godot", "Blender"};
  return {"three.js", "Babylon.js", "PlayCanvas", "Filament", "Godot 3", "Blender"};
}

std::string engine_line(MaterialFormat format, MaterialTexels texels, const std::string& uastc) {
  const std::vector<std::string> engines = engines_that_fail(format, texels);
  if (engines.empty()) return "";
  std::string line = "known not to load: ";
  for (std::size_t i = 0; i < engines.size(); ++i) line += (i > 0 ? ", " : "") + engines[i];
  if (format == MaterialFormat::kKtx2 && texels != MaterialTexels::kUastc)
    line += " (some show no message; the first three load only files written with " + uastc + ")";
  else if (format == MaterialFormat::kDds)
    line += " (some show no message; web engines load --format ktx2 " + uastc + ")";
  return line;
}

}  // namespace multum
