// SPDX-License-Identifier: Apache-2.0
// Writes and reads baked files of spherical harmonics row by row (docs/reference/file_format.md, "Spherical
// harmonics"). All parts store all levels. The parts "sh.00", "sh.01", ... hold four coefficients each. If the map has
// colours, there is also a part "colour".
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/averages/sh_mipmap.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Returns the side of tiles. This is the default, or a smaller side if many coefficients per texel would make a row of
/// tiles large. The writer holds an unfinished row of tiles for every level. The result depends only on the arguments,
/// so a file always has the same bytes.
int sh_tile_size(int map_width, int order, int default_size);

/// Writes rows like MovmfWriter (host/formats/asset/lobes/movmf_writer.h), but stores level 0 like any other level.
class ShWriter {
 public:
  /// Ignores the measured error and the content hash in `header`, because commit() sets both. Throws like AtomicFile if
  /// the path cannot be written, and throws Error(kUsage) for an unknown compression.
  ShWriter(const std::string& path, const BakedHeader& header, int order, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~ShWriter();
  ShWriter(const ShWriter&) = delete;
  ShWriter& operator=(const ShWriter&) = delete;

  /// Takes `rows.height` rounded rows of a stored level. The rows of a level come in order from row 0. The levels come
  /// in any order.
  void write_level(int level, int first_row, ShLevel rows);
  void commit(const std::string& measured_error, Progress* progress = nullptr);
  /// Returns the checksum of the content. Call commit() first.
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// Reads rows with several threads. Only one thread may call this object at a time.
class ShReader {
 public:
  /// Opens the file and checks its structure. Throws Error(kInput), which names the file, what was found and what was
  /// expected. Decompresses with `threads` threads. 0 means one thread per core.
  explicit ShReader(const std::string& path, int threads = 0, TexelCheck check = TexelCheck::kRefuse);
  ~ShReader();
  ShReader(const ShReader&) = delete;
  ShReader& operator=(const ShReader&) = delete;

  const BakedHeader& header() const;
  int order() const;
  /// The height of one row of tiles. The reader decompresses whole rows of tiles.
  int tile_size() const;
  /// Reads rows of a stored level.
  ShLevel read_level(int level, int first_row, int row_count);
  /// Returns the checksum of the file's content for verify_sh(). Before the call, every row of every stored level must
  /// have been read once, from the top.
  std::string finish_hash();
  const std::vector<std::string>& changed_rows() const;  // rows that TexelCheck::kReport has found

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace multum
