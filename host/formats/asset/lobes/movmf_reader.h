// SPDX-License-Identifier: Apache-2.0
// Reads rows of a baked file. read_movmf_mipmap() reads all rows, and read_movmf_header() reads none.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Reads rows with several threads. Only one thread may call this object at a time.
class MovmfReader {
 public:
  /// Opens the file and checks its structure. Throws Error(kInput), which names the file, what was found and what was
  /// expected. Decompresses with `threads` threads. 0 means one thread per core.
  explicit MovmfReader(const std::string& path, int threads = 0, TexelCheck check = TexelCheck::kRefuse);
  ~MovmfReader();
  MovmfReader(const MovmfReader&) = delete;
  MovmfReader& operator=(const MovmfReader&) = delete;

  /// Returns all contents except for texels. Levels have sizes, but their lobes are empty.
  const MovmfMipmap& header() const;
  /// The height of one row of tiles. If each read begins at a multiple of this height and covers a multiple of it, no
  /// row is decompressed twice.
  int tile_size() const;
  /// The damaged rows that TexelCheck::kReport found, such as "part lobe.1, level 3, texel rows 0 to 127".
  const std::vector<std::string>& changed_rows() const;
  /// Reads rows of a stored level. Level 0 is expanded to full lobes.
  MovmfLevel read_level(int level, int first_row, int row_count);
  /// Reads rows of level 0. The file must store level 0 (the first level in its header is 0).
  MovmfFinest read_finest(int first_row, int row_count);

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace multum
