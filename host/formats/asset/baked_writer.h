// SPDX-License-Identifier: Apache-2.0
// Writes rows to a baked file of any representation while the bake continues. A separate thread collects rows of texels
// into rows of tiles, hashes them, and has OpenEXR compress them. Only unfinished rows of tiles stay in memory. Only
// host/formats/asset uses this file. Bakes use MovmfWriter, MomentWriter and ShWriter.
#pragma once

#include <ImfHeader.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/baked_header.h"
#include "host/formats/asset/baked_verify.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Complete rows of one level. Each representation defines their contents.
class BakedRows {
 public:
  virtual ~BakedRows() = default;
  virtual int level() const = 0;
  virtual int height() const = 0;
  /// The memory that the rows use while they wait in the queue.
  virtual std::size_t bytes() const = 0;
  /// Checks with MULTUM_CHECK that all values of a level of this width are present.
  virtual void check_sizes(int level_width) const = 0;
  /// Copies the values of `count` texels of the rows, beginning with texel `first`. The values are interleaved like the
  /// channels of the part. This function runs in the writer's thread.
  virtual void copy_values(std::size_t part, std::size_t first, std::size_t count, float* values) const = 0;
  /// Checks every texel like `multum verify`. `first_row` is the number of the first of these rows in their level. This
  /// function runs in the writer's thread.
  virtual void scan(int first_row) const = 0;
};

/// Writes rows in the background. Only one thread may call this object at a time. If writing fails in the background
/// (for example, because the disk is full), the next call throws Error(kEnvironment) with the file's name and the
/// reason.
class BakedWriter {
 public:
  /// Takes one header per part. Throws like AtomicFile if the path cannot be written.
  BakedWriter(const std::string& path, const BakedHeader& header, std::vector<BakedPart> parts,
              const std::vector<Imf::Header>& headers, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~BakedWriter();
  BakedWriter(const BakedWriter&) = delete;
  BakedWriter& operator=(const BakedWriter&) = delete;

  /// Takes the rows of each level in order, beginning with row 0. The levels may come in any order. Blocks while more
  /// than about 16 MiB of rows are waiting.
  void write(int first_row, std::unique_ptr<const BakedRows> rows);
  /// Finishes the file after every row of every stored level was written. Waits for the writer's thread, fills in the
  /// last attributes, syncs the file, and gives it its final name. `measured_error` is JSON of at most
  /// options.measured_error_bytes bytes. Counts no units of progress. The progress callback can cancel until the file
  /// is renamed to its final name. Throws Error(kEnvironment) and leaves no file if one of the `findings` on the
  /// scanned rows failed.
  void commit(const std::string& measured_error, const std::function<std::vector<VerifyFinding>()>& findings,
              Progress* progress);
  /// Returns the checksum of the content (docs/reference/file_format.md). Call commit() first.
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace multum
