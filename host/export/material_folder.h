// SPDX-License-Identifier: Apache-2.0
// Writes an exported material: an image a level and texture, FOLDER/normal_00.png, orm_00.png and, where there is
// anisotropy, anisotropy_00.png; or a KTX2 file a texture with all its levels, FOLDER/normal.ktx2. orm is as glTF has
// it: occlusion in red, roughness in green, metalness in blue, 1 where there is no such map. anisotropy is as
// KHR_materials_anisotropy has it: the direction in red and green, the strength in blue. Alpha, where files have it, is
// 1.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/export/material_rows.h"

namespace multum {

enum class MaterialEncoding {
  kUnorm8,  // normals and directions as 0.5 + 0.5 n
  kHalf,    // as they are
};

/// Rounds rows to what is stored. Rounded rows stay as they are when they are rounded again.
void round_material(MaterialRows& rows, MaterialEncoding encoding);

/// Where an exported material goes, rounded rows as they come.
class MaterialWriter : public MaterialSink {
 public:
  /// Gives all files their names, after all rows of all levels.
  virtual void commit() = 0;
};

enum class MaterialFormat { kPng, kExr, kKtx2, kKtx2Half };

struct MaterialFolderSettings {
  std::string folder;  // which exists
  MaterialFormat format = MaterialFormat::kPng;
  bool has_anisotropy = false;
};

/// PNG is of 8 bits, EXR of half floats; KTX2 of either.
MaterialEncoding encoding_of(MaterialFormat format);

/// Files of a map of this size, in the order of textures and levels.
std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height);

/// Makes the files. Everything throws Error(kEnvironment) when the disk refuses; without commit() none is left.
std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height);

}  // namespace multum
