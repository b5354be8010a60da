// SPDX-License-Identifier: Apache-2.0
// Writes rows to a baked file of lobes while the bake continues. A separate thread collects rows of texels into rows of
// tiles, hashes them, and has OpenEXR compress them. Only unfinished rows of tiles stay in memory.
#pragma once

#include <memory>
#include <string>

#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/progress.h"

namespace multum {

class BakedWriter;

/// Writes rows in the background. Only one thread may call this object at a time. If writing fails in the background
/// (for example, because the disk is full), the next call throws Error(kEnvironment) with the file's name and the
/// reason.
class MovmfWriter {
 public:
  /// `header` holds sizes, lobe count, encoding, wrap modes, first level, the flag for colours, and provenance, but no
  /// texels. The measured error and content hash in `header` are ignored, because commit() sets both. Throws like
  /// AtomicFile if the path cannot be written, and throws Error(kUsage) for an unknown compression.
  MovmfWriter(const std::string& path, const MovmfMipmap& header, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~MovmfWriter();
  MovmfWriter(const MovmfWriter&) = delete;
  MovmfWriter& operator=(const MovmfWriter&) = delete;

  /// Takes any number of rounded rows of level 0, in order from row 0. The first level in the header must be 0. Blocks
  /// while more than about 16 MiB of rows are waiting.
  void write_finest(int first_row, MovmfFinest rows);
  /// Takes `rows.height` rounded rows of a level other than level 0. The rows of a level come in order from row 0. The
  /// levels come in any order, even between rows of level 0.
  void write_level(int level, int first_row, MovmfLevel rows);
  /// Finishes the file after every row of every stored level was written. Waits for the writer's thread, fills in the
  /// last attributes, syncs the file, and gives it its final name. `measured_error` is JSON of at most
  /// options.measured_error_bytes bytes. Counts no units of progress. The progress callback can cancel until the file
  /// is renamed to its final name.
  void commit(const std::string& measured_error, Progress* progress = nullptr);
  /// Returns the checksum of the content (docs/reference/file_format.md). Call commit() first.
  const std::string& content_hash() const;

  struct Shape;

 private:
  std::unique_ptr<const Shape> shape_;  // outlives the writer's rows
  std::unique_ptr<BakedWriter> writer_;
};

}  // namespace multum
