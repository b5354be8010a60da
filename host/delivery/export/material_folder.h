// SPDX-License-Identifier: Apache-2.0
// Writes an exported material. In image formats, each level of a texture is an image, such as FOLDER/normal_00.png,
// orm_00.png and, with anisotropy, anisotropy_00.png. In KTX2 and DDS, each texture is one file with all its levels,
// such as FOLDER/normal.ktx2. As in glTF, orm contains occlusion in red, roughness in green and metalness in blue. If
// there are no maps, occlusion is 1 and metalness is 0. For Unity, orm is replaced by mask, which contains metalness in
// red, occlusion in green, 1 in blue (HDRP's detail mask) and smoothness in alpha. Separate textures have one channel,
// and exist only for the maps that the material has. As in KHR_materials_anisotropy,
// anisotropy contains the direction in red and green, and the strength in blue. The alpha channel of all textures
// except mask is 1.
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
/// would change nothing. Inputs of block encoders are rounded to 8 bits or not at all. This rounding does not include
/// the errors of blocks.
void round_material(MaterialRows& rows, MaterialTexels texels);

/// Writes an exported material from rows as they arrive, rounded or not.
class MaterialWriter : public MaterialSink {
 public:
  /// Encodes textures that are encoded as a whole, after all rows of all levels, and passes the stored rows to
  /// `stored`. Throws Error(kEnvironment) and Cancelled.
  virtual void encode(Progress* progress) = 0;
  /// Renames all files to their final names. Call this function after encode().
  virtual void commit() = 0;
};

struct MaterialFolderSettings {
  std::string folder;  // an existing folder
  MaterialFormat format = MaterialFormat::kPng;
  bool has_anisotropy = false;
  MaterialTexels texels = MaterialTexels::kRgba8;  // always kRgba16f for EXR and kRgba8 for PNG
  std::string material;                            // begins the file names: "rock" for rock_normal.ktx2; may be empty
  TextureNames names = TextureNames::kPlain;       // only plain names may lack a material
  // Zstandard level of KTX2 files, 1..kZstdLevelMax. If 0, files are not supercompressed.
  int zstd_level = 0;
  MaterialPacking packing = MaterialPacking::kOrm;
  bool has_occlusion = false, has_metalness = false;  // write separate textures of these maps
  bool green_is_down = false;                         // negate the y component of normals and directions
  UastcSettings uastc = {};                           // settings of kUastc
};

/// Returns whether an image format can store the texels. KTX2 and DDS store all texel formats.
bool can_store(MaterialFormat format, MaterialTexels texels);

/// Returns a text such as "normal, orm", in the order of the files.
std::string texture_list(const MaterialFolderSettings& settings);

/// Returns the files of a map of this size, in the order of textures and levels.
std::vector<std::string> material_files(const MaterialFolderSettings& settings, int width, int height);

/// Throws Error(kInput) if the sides of the map at `path` break the rule.
void check_sides(SideRule rule, const std::string& path, int width, int height);

/// Returns human-readable warnings about readers that cannot handle textures of this size correctly.
std::vector<std::string> side_warnings(const MaterialFolderSettings& settings, int width, int height);

/// Makes the files. `device` encodes blocks and must outlive the result. `stored` receives the rows in the form in
/// which a reader will see them, and may be null. All functions throw Error(kEnvironment) if the disk or device fails.
/// Without commit(), no file is left.
std::unique_ptr<MaterialWriter> make_material_folder(const MaterialFolderSettings& settings, int width, int height,
                                                     Device& device, MaterialSink* stored);

}  // namespace multum
