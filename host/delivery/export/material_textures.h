// SPDX-License-Identifier: Apache-2.0
// The textures of an exported material: which there are, what their channels hold, and the files that they become.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "host/delivery/export/block_encoder.h"
#include "host/delivery/export/material_folder.h"
#include "host/delivery/export/material_rows.h"
#include "host/foundation/base/progress.h"

namespace multum {

enum class TextureRole {
  kNormal,
  kOrm,         // occlusion, roughness, metalness: glTF, Unreal
  kMask,        // metalness, occlusion, 1, smoothness: Unity
  kRoughness,   // alone
  kSmoothness,  // alone
  kAnisotropy,  // direction x and y, strength: KHR_materials_anisotropy
};

const char* name_of(TextureRole role);
/// In the order of files.
std::vector<TextureRole> roles_of(const MaterialFolderSettings& settings);

/// Files of a texture, level 0 first.
std::vector<std::string> texture_files(const MaterialFolderSettings& settings, TextureRole role, int level_count);

inline bool is_half(MaterialTexels texels) { return texels == MaterialTexels::kRgba16f; }

/// The nearest step of 8 bits, of values from 0 to 1. std::lround, a call, would be a twelfth of an export's time.
inline std::uint8_t code_of(float share) { return static_cast<std::uint8_t>(share * 255.0f + 0.5f); }

/// z of a unit normal, from the other two.
inline float rebuilt_z(const glm::vec3& normal) {
  return std::sqrt(std::max(0.0f, 1.0f - normal.x * normal.x - normal.y * normal.y));
}

/// Red, green, blue, alpha as they are stored, those of 8 bits as shares.
std::vector<glm::vec4> texels_of(TextureRole role, const MaterialFolderSettings& settings, const MaterialRows& rows);
/// The other way round, of texels that are stored as blocks. Planes that `rows` lacks stay empty.
void set_rows(TextureRole role, const MaterialFolderSettings& settings, const std::vector<glm::vec4>& texels,
              MaterialRows& rows);

/// The files of one texture.
class TextureFiles {
 public:
  virtual ~TextureFiles() = default;
  /// Takes the next rows of a level, rounded; of blocks whole ones, or the level's last. They become what is stored.
  virtual void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) = 0;
  /// Encodes the levels, after all rows, where that is done for whole textures. Throws Error(kEnvironment), Cancelled.
  virtual void encode(Progress*) {}
  /// Rows of a level as they are stored, after encode(); of textures that are encoded whole.
  virtual std::vector<glm::vec4> stored_rows(int level, int first_row, int row_count) const;
  /// Gives them their names.
  virtual void finish() = 0;
};

/// `encoder` must outlive it.
std::unique_ptr<TextureFiles> make_texture(const MaterialFolderSettings& settings, TextureRole role, int width,
                                           int height, BlockEncoder& encoder);

}  // namespace multum
