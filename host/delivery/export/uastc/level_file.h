// SPDX-License-Identifier: Apache-2.0
// A texture's mip levels on disk between their fit and their encoding: RGBA of 8 bits, level 0 first, each from its top
// row, one behind the other.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "host/foundation/base/files/scratch_file.h"

namespace multum {

class LevelFile {
 public:
  /// Throws Error(kEnvironment), as do its functions.
  LevelFile(const std::string& folder, const std::string& name, int width, int height);

  const std::string& path() const { return path_; }
  int width() const { return width_; }
  int height() const { return height_; }
  int level_count() const { return static_cast<int>(offsets_.size()) - 1; }
  /// Of its first byte; of level_count() the length of the file.
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
