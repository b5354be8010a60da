// SPDX-License-Identifier: Apache-2.0
// Defines the contents of the channels and the files of the textures of an exported material.
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
#include "host/delivery/export/engines/texture_names.h"
#include "host/delivery/export/material_folder.h"
#include "host/delivery/export/material_rows.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Returns the roles in the order of the files.
std::vector<TextureRole> roles_of(const MaterialFolderSettings& settings);

/// Returns the files of a texture, level 0 first.
std::vector<std::string> texture_files(const MaterialFolderSettings& settings, TextureRole role, int level_count);

inline bool is_half(MaterialTexels texels) { return texels == MaterialTexels::kRgba16f; }

/// Rounds a value from 0 to 1 to the nearest 8-bit code. Does not call std::lround, which would take a twelfth of the
/// time of an export.
inline std::uint8_t code_of(float share) { return static_cast<std::uint8_t>(share * 255.0f + 0.5f); }

/// Returns z of a unit normal, computed from x and y.
inline float rebuilt_z(const glm::vec3& normal) {
  return std::sqrt(std::max(0.0f, 1.0f - normal.x * normal.x - normal.y * normal.y));
}

/// Returns stored red, green, blue and alpha. Values of 8 bits are converted to shares from 0 to 1.
std::vector<glm::vec4> texels_of(TextureRole role, const MaterialFolderSettings& settings, const MaterialRows& rows);
/// Converts texels that are stored as blocks back to rows. Planes that are empty in `rows` stay empty.
void set_rows(TextureRole role, const MaterialFolderSettings& settings, const std::vector<glm::vec4>& texels,
              MaterialRows& rows);

/// The files of one texture.
class TextureFiles {
 public:
  virtual ~TextureFiles() = default;
  /// Writes the next rounded rows of a level. In block formats, the rows must fill whole blocks, except for the last
  /// rows of a level. Replaces `texels` with the stored values.
  virtual void write_rows(int level, int row_count, std::vector<glm::vec4>& texels) = 0;
  /// Encodes the levels of a format that is encoded as a whole, after all rows have been written. Throws
  /// Error(kEnvironment) and Cancelled.
  virtual void encode(Progress*) {}
  /// Returns stored rows of a level in a format that is encoded as a whole. Call this function after encode().
  virtual std::vector<glm::vec4> stored_rows(int level, int first_row, int row_count) const;
  /// Renames the files to their final names.
  virtual void finish() = 0;
};

/// `encoder` must outlive the result.
std::unique_ptr<TextureFiles> make_texture(const MaterialFolderSettings& settings, TextureRole role, int width,
                                           int height, BlockEncoder& encoder);

}  // namespace multum
