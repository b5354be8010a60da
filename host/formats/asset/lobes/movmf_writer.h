// SPDX-License-Identifier: Apache-2.0
// Writes a baked file from rows as they become ready, while the bake goes on. A thread of its own gathers rows to rows
// of tiles, hashes them and has OpenEXR compress them; nothing but rows of tiles that are not yet full is held.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/progress.h"

namespace multum {

class BakedWriter;

/// Calls come from one thread at a time. What goes wrong in the background (a full disk) is thrown by the next call as
/// Error(kEnvironment) with the file's name and the reason.
class MovmfWriter {
 public:
  /// `header` has sizes, lobe count, encoding, wraps, first level, whether there are colours, and provenance; no
  /// texels. Its measured error and content hash are not read: commit() knows them. Throws as AtomicFile does for
  /// places that cannot be written, Error(kUsage) for an unknown compression.
  MovmfWriter(const std::string& path, const MovmfMipmap& header, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~MovmfWriter();
  MovmfWriter(const MovmfWriter&) = delete;
  MovmfWriter& operator=(const MovmfWriter&) = delete;

  /// Rounded rows of level 0, any number of them, in order from row 0. Only where the header's first level is 0. Blocks
  /// while more than some 16 MiB wait.
  void write_finest(int first_row, MovmfFinest rows);
  /// Rounded rows of a level >= 1 (rows.height of them), in order from row 0 within the level; levels in any order, and
  /// between rows of level 0.
  void write_level(int level, int first_row, MovmfLevel rows);
  /// Waits for all that was handed in (every row of every stored level), writes what the header can only say at the
  /// end, syncs, and gives the file its name. `measured_error` is JSON of at most options.measured_error_bytes.
  /// Progress: counts no units; cancels until the file gets its name.
  void commit(const std::string& measured_error, Progress* progress = nullptr);
  /// The content's checksum as docs/reference/file_format.md defines it; after commit().
  const std::string& content_hash() const;

  struct Shape;

 private:
  std::unique_ptr<const Shape> shape_;  // outlives the writer's rows
  std::unique_ptr<BakedWriter> writer_;
};

}  // namespace multum
