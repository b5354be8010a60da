// SPDX-License-Identifier: Apache-2.0
// Writes and reads baked files of moments row by row (docs/reference/file_format.md, "Moments"). The parts
// "bumpslopes", "normal" and, if the map has colours, "colour" store all levels. The first part has the layout that
// maketx --bumpslopes writes, so a renderer that reads such textures can read this file.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The value of BakedWriteOptions::measured_error_bytes. The errors of 16 levels with colours, for three shading
/// methods and four BRDFs, need 94 KiB (test AccuracyTable.TheLongestFitsIntoTheRoomOfAHeader).
constexpr int kMomentErrorBytes = 112 * 1024;

/// Writes rows like MovmfWriter (host/formats/asset/lobes/movmf_writer.h), but stores level 0 like any other level.
class MomentWriter {
 public:
  /// Ignores the measured error and the content hash in `header`, because commit() sets both. Throws like AtomicFile if
  /// the path cannot be written, and throws Error(kUsage) for an unknown compression.
  MomentWriter(const std::string& path, const BakedHeader& header, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~MomentWriter();
  MomentWriter(const MomentWriter&) = delete;
  MomentWriter& operator=(const MomentWriter&) = delete;

  /// Takes `rows.height` rounded rows of a stored level. The rows of a level come in order from row 0. The levels come
  /// in any order.
  void write_level(int level, int first_row, MomentLevel rows);
  void commit(const std::string& measured_error, Progress* progress = nullptr);
  /// Returns the checksum of the content. Call commit() first.
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// Reads rows with several threads. Only one thread may call this object at a time.
class MomentReader {
 public:
  /// Opens the file and checks its structure. Throws Error(kInput), which names the file, what was found and what was
  /// expected. Decompresses with `threads` threads. 0 means one thread per core.
  explicit MomentReader(const std::string& path, int threads = 0, TexelCheck check = TexelCheck::kRefuse);
  ~MomentReader();
  MomentReader(const MomentReader&) = delete;
  MomentReader& operator=(const MomentReader&) = delete;

  const BakedHeader& header() const;
  /// The height of one row of tiles. The reader decompresses whole rows of tiles.
  int tile_size() const;
  /// Reads rows of a stored level.
  MomentLevel read_level(int level, int first_row, int row_count);
  /// Returns the checksum of the file's content for verify_moments(). Before the call, every row of every stored level
  /// must have been read once, from the top.
  std::string finish_hash();
  const std::vector<std::string>& changed_rows() const;  // rows that TexelCheck::kReport has found

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace multum
