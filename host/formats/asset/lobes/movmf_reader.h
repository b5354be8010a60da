// SPDX-License-Identifier: Apache-2.0
// Reads rows of a baked file. read_movmf_mipmap() reads all of them, read_movmf_header() none.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"

namespace multum {

/// Calls come from one thread at a time; each uses several.
class MovmfReader {
 public:
  /// Opens the file and checks its structure. Throws Error(kInput) naming the file, what was found and what was
  /// expected. `threads` decompress; 0: as many as the machine has.
  explicit MovmfReader(const std::string& path, int threads = 0, TexelCheck check = TexelCheck::kRefuse);
  ~MovmfReader();
  MovmfReader(const MovmfReader&) = delete;
  MovmfReader& operator=(const MovmfReader&) = delete;

  /// Everything but texels: levels have sizes and empty lobes.
  const MovmfMipmap& header() const;
  /// Rows are decompressed by rows of tiles of this height: multiples of it, from a multiple on, cost no row twice.
  int tile_size() const;
  /// "part lobe.1, level 3, texel rows 0 to 127", of TexelCheck::kReport.
  const std::vector<std::string>& changed_rows() const;
  /// Rows of a stored level. Level 0 is expanded to full lobes.
  MovmfLevel read_level(int level, int first_row, int row_count);
  /// Rows of level 0; only where the header's first level is 0.
  MovmfFinest read_finest(int first_row, int row_count);

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace multum
