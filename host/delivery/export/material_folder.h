// SPDX-License-Identifier: Apache-2.0
// Writes an exported material. Image formats give one image per level and texture: FOLDER/normal_00.png, orm_00.png
// and, with anisotropy, anisotropy_00.png. KTX2 and DDS give one file per texture with all its levels:
// FOLDER/normal.ktx2. orm follows glTF: occlusion is in red, roughness in green, and metalness in blue. Without maps,
// occlusion is 1 and metalness 0. For Unity, orm is replaced by mask: metalness is in red, occlusion in green, 1 in
// blue (HDRP's detail mask), and smoothness in alpha. anisotropy follows KHR_materials_anisotropy: the direction is in
// red and green, the strength in blue. The alpha channel of other textures is 1.
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

/// Rounds rows to the stored precision, and rebuilds the values that are not stored. Rounding the rows a second time
/// changes nothing. Inputs of block encoders have 8 bits or are not rounded. The errors of blocks are not part of this
/// rounding.
void round_material(MaterialRows& rows, MaterialTexels texels);

/// Writes an exported material from rows as they arrive, rounded or not.
class MaterialWriter : public MaterialSink {
 public:
  /// Encodes textures that are encoded as a whole, after all rows of all levels, and passes the stored rows to
  /// `stored`. Throws Error(kEnvironment) and Cancelled.
  virtual void encode(Progress* progress) = 0;
  /// Gives all files their final names, after encode().
  virtual void commit() = 0;
};

struct MaterialFolderSettings {
  std::string folder;  // an existing folder
  MaterialFormat format = MaterialFormat::kPng;
  bool has_anisotropy = false;
  MaterialTexels texels = MaterialTexels::kRgba8;  // always kRgba16f for EXR and kRgba8 for PNG
  std::string name_prefix;                         // prefix of the file names: "rock_" for rock_normal.ktx2
  // Zstandard level of KTX2 files, 1..kZstdLevelMax. If 0, files are not supercompressed.
  int zstd_level = 0;
  bool has_roughness_alone = false;  // write a texture of one channel, roughness or smoothness
  bool has_smoothness = false;       // write smoothness instead of roughness, and mask instead of orm
  bool green_is_down = false;        // negate the y component of normals and directions
  UastcSettings uastc = {};          // settings of kUastc
};

/// Returns whether an image format can store the texels. KTX2 and DDS store all texel formats.
bool can_store(MaterialFormat format, MaterialTexels texels);

/// Returns text such as "normal, orm", in the order of the files.
std::string texture_list(const MaterialFolderSettings& settings);

/// Returns the files of a map of this size, in the order of textures and levels.
std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height);

/// Returns human-readable warnings about readers that handle files with these sides incorrectly.
std::vector<std::string> side_warnings(const MaterialFolderSettings& settings, int width, int height);

/// Makes the files. `device` encodes blocks and must outlive the result. `stored` receives the rows as a reader will
/// find them, and may be null. All functions throw Error(kEnvironment) if the disk or device fails. Without commit(),
/// no file is left.
std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height,
                                                     Device& device, MaterialSink* stored);

}  // namespace multum
