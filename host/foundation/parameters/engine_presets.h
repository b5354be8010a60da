// SPDX-License-Identifier: Apache-2.0
// Lists the settings that `--for ENGINE` selects for `multum export` and `multum gltf`. Each setting is also an option,
// which replaces the preset's value. docs/contributing/DEPENDENCIES.md lists the sources of these values.
#pragma once

#include <string>

#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

struct EnginePreset {
  Engine engine;
  const char* title;  // the engine's own name, such as "Unity HDRP"
  const char* page;   // page with import steps in docs/how-to
  // Settings of `multum export`. If the output is NAME.ktx2 or NAME.dds, its extension replaces `format`.
  MaterialFormat format;
  MaterialTexels texels;
  GreenAxis green;
  MaterialPacking packing;
  TextureNames names;
  SideRule sides;
  int zstd_level = 0;  // only for KTX2
  // Setting of `multum gltf`.
  GltfTextureFormat gltf_format = GltfTextureFormat::kPng;
  const char* note = "";  // what the engine does not use
};

const EnginePreset& preset_of(Engine engine);

/// Returns the settings of `multum export` as text, such as "dds, rgba8, green down, orm".
std::string preset_text(const EnginePreset& preset);

/// Returns what a packing puts where, such as "roughness in green of orm" or "smoothness in alpha of mask".
std::string packing_text(MaterialPacking packing);

}  // namespace multum
