// SPDX-License-Identifier: Apache-2.0
// Stores a texture's mip levels on disk as 8-bit RGBA between the fit and the encoding. Levels follow one another,
// beginning with level 0, and each level begins with its top row.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/foundation/base/files/scratch_file.h"

namespace multum {

class LevelFile {
 public:
  /// The constructor and all functions throw Error(kEnvironment).
  LevelFile(const std::string& folder, const std::string& name, int width, int height);

  const std::string& path() const { return path_; }
  int width() const { return width_; }
  int height() const { return height_; }
  int level_count() const { return static_cast<int>(offsets_.size()) - 1; }
  /// Returns the offset of the level's first byte. For level_count(), returns the file's length.
  std::uint64_t offset(int level) const { return offsets_[static_cast<std::size_t>(level)]; }

  void write_rows(int level, int first_row, const std::vector<std::uint8_t>& texels);
  std::vector<std::uint8_t> read_rows(int level, int first_row, int row_count) const;
  std::array<std::uint8_t, 4> read_texel(int level, int x, int y) const;

 private:
  std::uint64_t row_offset(int level, int row) const;

  std::string path_;
  int width_, height_;
  std::vector<std::uint64_t> offsets_;
  ScratchFile file_;
};

}  // namespace multum
