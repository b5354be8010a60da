// SPDX-License-Identifier: Apache-2.0
// Writes an exported material: an image a level and texture, FOLDER/normal_00.png, orm_00.png and, where there is
// anisotropy, anisotropy_00.png; or a KTX2 or DDS file a texture with all its levels, FOLDER/normal.ktx2. orm is as
// glTF has it: occlusion in red, roughness in green, metalness in blue; without such maps occlusion is 1 and metalness
// 0. mask, in its place, is as Unity has it: metalness in red, occlusion in green, 1 in blue (HDRP's detail mask),
// smoothness in alpha. anisotropy is as KHR_materials_anisotropy has it: the direction in red and green, the strength
// in blue. Other textures' alpha, where files have it, is 1.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/delivery/export/material_rows.h"
#include "host/delivery/export/uastc/uastc_encoder.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "host/foundation/parameters/parameter_choices.h"

namespace multum {

/// Rounds rows to what is stored, and rebuilds what is not. Rounded rows stay as they are when they are rounded again.
/// What encoders of blocks are given is 8 bits too, or not rounded; their errors are no matter of rounding.
void round_material(MaterialRows& rows, MaterialTexels texels);

/// Where an exported material goes, rows as they come, rounded or not.
class MaterialWriter : public MaterialSink {
 public:
  /// Encodes what is encoded as whole textures, after all rows of all levels, and shows it to whoever is shown the
  /// rows. Throws Error(kEnvironment), Cancelled.
  virtual void encode(Progress* progress) = 0;
  /// Gives all files their names, after encode().
  virtual void commit() = 0;
};

struct MaterialFolderSettings {
  std::string folder;  // which exists
  MaterialFormat format = MaterialFormat::kPng;
  bool has_anisotropy = false;
  MaterialTexels texels = MaterialTexels::kRgba8;  // of EXR always kRgba16f, of PNG always kRgba8
  std::string name_prefix;                         // of files' names: "rock_" for rock_normal.ktx2
  int zstd_level = 0;                              // of KTX2 files, 1..kZstdLevelMax; 0: not supercompressed
  bool has_roughness_alone = false;                // a texture of one channel, roughness or smoothness
  bool has_smoothness = false;                     // instead of roughness: mask instead of orm
  bool green_is_down = false;                      // y of normals and of directions is negated
  UastcSettings uastc = {};                        // of kUastc
};

/// What an image format can store; KTX2 and DDS all.
bool can_store(MaterialFormat format, MaterialTexels texels);

/// "normal, orm", in the order of files.
std::string texture_list(const MaterialFolderSettings& settings);

/// Files of a map of this size, in the order of textures and levels.
std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height);

/// What readers do with files of these sides that they should not: texts for people.
std::vector<std::string> side_warnings(const MaterialFolderSettings& settings, int width, int height);

/// Makes the files. `device` encodes blocks; it has to outlive them. `stored`: gets the rows as a reader finds them;
/// null: nobody. Everything throws Error(kEnvironment) when disk or device refuse; without commit() no file is left.
std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height,
                                                     Device& device, MaterialSink* stored);

}  // namespace multum
