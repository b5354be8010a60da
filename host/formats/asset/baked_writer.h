// SPDX-License-Identifier: Apache-2.0
// Writes a baked file of any representation from rows as they become ready, while the bake goes on. A thread of its own
// gathers rows to rows of tiles, hashes them and has OpenEXR compress them; nothing but rows of tiles that are not yet
// full is held. For host/formats/asset alone: MovmfWriter, MomentWriter and ShWriter are what bakes
// use.
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

/// Rows of one level, from the left of the first: what they are is a representation's matter.
class BakedRows {
 public:
  virtual ~BakedRows() = default;
  virtual int level() const = 0;
  virtual int height() const = 0;
  /// Bytes that the rows take while they wait.
  virtual std::size_t bytes() const = 0;
  /// MULTUM_CHECKs that there is all that a level of this width needs.
  virtual void check_sizes(int level_width) const = 0;
  /// Values of `count` texels from texel `first` of the rows on, as the part's channels, interleaved. In the writer's
  /// thread.
  virtual void copy_values(std::size_t part, std::size_t first, std::size_t count, float* values) const = 0;
  /// Looks at every texel as `multum verify` does; the rows are those from `first_row` of their level. In the writer's
  /// thread.
  virtual void scan(int first_row) const = 0;
};

/// Calls come from one thread at a time. What goes wrong in the background (a full disk) is thrown by the next call as
/// Error(kEnvironment) with the file's name and the reason.
class BakedWriter {
 public:
  /// `headers`: one a part. Throws as AtomicFile does for places that cannot be written.
  BakedWriter(const std::string& path, const BakedHeader& header, std::vector<BakedPart> parts,
              const std::vector<Imf::Header>& headers, const BakedWriteOptions& options);
  /// Removes the file, unless commit() was called.
  ~BakedWriter();
  BakedWriter(const BakedWriter&) = delete;
  BakedWriter& operator=(const BakedWriter&) = delete;

  /// In order from row 0 within a level, levels in any order. Blocks while more than some 16 MiB wait.
  void write(int first_row, std::unique_ptr<const BakedRows> rows);
  /// Waits for all that was handed in (every row of every stored level), writes what the header can only say at the
  /// end, syncs, and gives the file its name. `measured_error` is JSON of at most options.measured_error_bytes.
  /// Progress: counts no units; cancels until the file gets its name. `findings` of what was scanned: when one has not
  /// passed, throws Error(kEnvironment), and there is no file.
  void commit(const std::string& measured_error, const std::function<std::vector<VerifyFinding>()>& findings,
              Progress* progress);
  /// The content's checksum as docs/reference/file_format.md defines it; after commit().
  const std::string& content_hash() const;

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace multum
