// SPDX-License-Identifier: Apache-2.0
// Reads rows of a baked file of any representation, and hashes them. Only host/formats/asset uses this file. Other code
// uses MovmfReader, MomentReader and ShReader.
#pragma once

#include <ImfMultiPartInputFile.h>

#include <memory>
#include <string>
#include <vector>

#include "host/formats/asset/baked_header.h"
#include "host/formats/asset/exr/exr_input.h"
#include "host/formats/asset/row_checksums.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/exr_chunks.h"

namespace multum {

/// Reads rows with several threads. Only one thread may call this object at a time.
class BakedReader {
 public:
  /// Throws Error(kInput), which names the file. Decompresses with `threads` threads. 0 means one thread per core.
  BakedReader(const std::string& path, int threads, TexelCheck check = TexelCheck::kRefuse);

  const std::string& path() const { return path_; }
  int threads() const { return threads_; }
  const Imf::MultiPartInputFile& file() const { return *file_; }
  /// The height of one row of tiles. If each read begins at a multiple of this height and covers a multiple of it, no
  /// row is decompressed twice.
  int tile_size() const { return tile_size_; }

  /// Sets the contents that the file must have according to its header. Call it once, before reading rows. Throws
  /// Error(kInput) if the parts differ, or if a tile is misplaced or cut short.
  void expect(const BakedHeader& header, std::vector<BakedPart> parts);
  /// Reads some rows of a level of a part as interleaved floats. Writes every value, or throws Error(kInput), which
  /// names the tile that cannot be unpacked, or the row of tiles that has a wrong checksum. A file of an older program
  /// has only one checksum, so the first call reads the whole file.
  void read_values(std::size_t part, int level, int first_row, int row_count, float* values);
  /// The damaged rows that TexelCheck::kReport found, such as "part lobe.1, level 3, texel rows 0 to 127".
  const std::vector<std::string>& changed_rows() const { return changed_rows_; }

  /// Converts exceptions of OpenEXR to Error.
  template <typename Body>
  void guarded(const Body& body) const {
    try {
      body();
    } catch (const Error&) {
      throw;
    } catch (const std::bad_alloc&) {
      throw;
    } catch (const std::exception& error) {
      throw Error(ErrorCode::kInput, path_ + ": not a readable baked file: " + error.what());
    }
  }

 private:
  struct TileRows;

  void read_tile_rows(const TileRows& rows, float* values);
  void unpack_tile(const TileRows& rows, std::size_t chunk, float* values) const;
  void read_by_library(const TileRows& rows, float* values);
  void check_tile_rows(const TileRows& rows, const float* values);
  void check_content_hash();

  const std::string path_;
  const int threads_;
  const TexelCheck check_;
  std::unique_ptr<ExrInputStream> stream_;  // stream of the file; outlives `file_`
  std::unique_ptr<Imf::MultiPartInputFile> file_;
  int tile_size_ = 1;
  BakedHeader header_;
  std::vector<BakedPart> parts_;
  std::unique_ptr<ExrChunks> chunks_;
  std::unique_ptr<RowChecksums> row_checksums_;  // null if the file has no checksums of rows
  bool is_content_checked_ = false;              // true after a file without row checksums has been checked
  std::vector<std::string> changed_rows_;
};

/// Computes the checksum of docs/reference/file_format.md. The rows must be added level by level, from the top.
class BakedRowHash {
 public:
  explicit BakedRowHash(const std::vector<BakedPart>& parts);

  /// Adds the next rows of a level of a part, as interleaved values. Several threads may add different parts and levels
  /// at the same time.
  void add(std::size_t part, int level, const float* values, std::size_t value_count);
  std::string finish();

 private:
  std::vector<int> first_levels_;                 // index: [part]
  std::vector<std::vector<ContentHash>> hashes_;  // index: [part][level of the part]
};

}  // namespace multum
