// SPDX-License-Identifier: Apache-2.0
// Writes and reads baked files of moments row by row (docs/reference/file_format.md, "Moments"): parts "bumpslopes",
// "normal" and, with colours, "colour", all levels each. The first part is what maketx --bumpslopes writes, so that a
// renderer that reads those reads this file.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Value of BakedWriteOptions::measured_error_bytes: errors of 16 levels with colours, three ways to shade four BRDFs
/// take 94 KiB (test AccuracyTable.TheLongestFitsIntoTheRoomOfAHeader).
constexpr int kMomentErrorBytes = 112 * 1024;

/// Writes rows as MovmfWriter does (host/formats/asset/lobes/movmf_writer.h); level 0 is a level like the others.
class MomentWriter {
 public:
  /// Does not read measured error and content hash of `header`: commit() knows them. Throws as AtomicFile does for
  /// places that cannot be written, Error(kUsage) for an unknown compression.
  MomentWriter(const std::string& path, const BakedHeader& header, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~MomentWriter();
  MomentWriter(const MomentWriter&) = delete;
  MomentWriter& operator=(const MomentWriter&) = delete;

  /// Rounded rows of a stored level (rows.height of them), in order from row 0 within the level; levels in any order.
  void write_level(int level, int first_row, MomentLevel rows);
  void commit(const std::string& measured_error, Progress* progress = nullptr);
  /// The content's checksum; after commit().
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

/// Calls come from one thread at a time; each uses several.
class MomentReader {
 public:
  /// Opens the file and checks its structure. Throws Error(kInput) naming the file, what was found and what was
  /// expected. `threads` decompress; 0: as many as the machine has.
  explicit MomentReader(const std::string& path, int threads = 0, TexelCheck check = TexelCheck::kRefuse);
  ~MomentReader();
  MomentReader(const MomentReader&) = delete;
  MomentReader& operator=(const MomentReader&) = delete;

  const BakedHeader& header() const;
  /// Rows are decompressed by rows of tiles of this height.
  int tile_size() const;
  /// Rows of a stored level.
  MomentLevel read_level(int level, int first_row, int row_count);
  /// The checksum of what the file holds, when every row of every stored level has been read once, from the top; for
  /// verify_moments().
  std::string finish_hash();
  const std::vector<std::string>& changed_rows() const;  // of TexelCheck::kReport

 private:
  class File;
  std::unique_ptr<File> file_;
};

}  // namespace multum
