// SPDX-License-Identifier: Apache-2.0
// Writes and reads baked files of spherical harmonics row by row (docs/reference/file_format.md, "Spherical
// harmonics"): parts "sh.00", "sh.01", ... of four coefficients each and, with colours, "colour", all levels each.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Sides of tiles: as usual where a row of them is small; lower where many coefficients lie side by side, since of
/// every level a row of tiles waits until it is full. Depends on nothing but the file: so do its bytes.
int sh_tile_size(int map_width, int order, int default_size);

/// Writes rows as MovmfWriter does (host/formats/asset/lobes/movmf_writer.h); level 0 is a level like the others.
class ShWriter {
 public:
  /// Does not read measured error and content hash of `header`: commit() knows them. Throws as AtomicFile does for
  /// places that cannot be written, Error(kUsage) for an unknown compression.
  ShWriter(const std::string& path, const BakedHeader& header, int order, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~ShWriter();
  ShWriter(const ShWriter&) = delete;
  ShWriter& operator=(const ShWriter&) = delete;

  /// Rounded rows of a stored level (rows.height of them), in order from row 0 within the level; levels in any order.
  void write_level(int level, int first_row, ShLevel rows);
  void commit(const std::string& measured_error, Progress* progress = nullptr);
  /// The content's checksum; after commit().
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// Calls come from one thread at a time; each uses several.
class ShReader {
 public:
  /// Opens the file and checks its structure. Throws Error(kInput) naming the file, what was found and what was
  /// expected. `threads` decompress; 0: as many as the machine has.
  explicit ShReader(const std::string& path, int threads = 0, TexelCheck check = TexelCheck::kRefuse);
  ~ShReader();
  ShReader(const ShReader&) = delete;
  ShReader& operator=(const ShReader&) = delete;

  const BakedHeader& header() const;
  int order() const;
  /// Rows are decompressed by rows of tiles of this height.
  int tile_size() const;
  /// Rows of a stored level.
  ShLevel read_level(int level, int first_row, int row_count);
  /// The checksum of what the file holds, when every row of every stored level has been read once, from the top; for
  /// verify_sh().
  std::string finish_hash();
  const std::vector<std::string>& changed_rows() const;  // of TexelCheck::kReport

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace multum
