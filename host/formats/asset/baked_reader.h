// SPDX-License-Identifier: Apache-2.0
// Reads rows of a baked file of any representation, and hashes what it read. For host/formats/asset alone: MovmfReader,
// MomentReader and ShReader are what others use.
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

/// Calls come from one thread at a time; each uses several.
class BakedReader {
 public:
  /// Throws Error(kInput) naming the file. `threads` decompress; 0: as many as the machine has.
  BakedReader(const std::string& path, int threads, TexelCheck check = TexelCheck::kRefuse);

  const std::string& path() const { return path_; }
  int threads() const { return threads_; }
  const Imf::MultiPartInputFile& file() const { return *file_; }
  /// Rows are decompressed by rows of tiles of this height: multiples of it, from a multiple on, cost no row twice.
  int tile_size() const { return tile_size_; }

  /// Once, before rows are read: what the file has, by its header. Throws Error(kInput) where it has something else,
  /// and where a tile is not where it should be, or its bytes cannot be all of it.
  void expect(const BakedHeader& header, std::vector<BakedPart> parts);
  /// Interleaved floats of some rows of a level that the part has: every one is written, or Error(kInput) is thrown. It
  /// names the tile that does not unpack, and the row of tiles whose texels are not those that were baked. A file
  /// without checksums of rows, of an earlier program, is read whole for its one checksum before the first rows.
  void read_values(std::size_t part, int level, int first_row, int row_count, float* values);
  /// "part lobe.1, level 3, texel rows 0 to 127", of TexelCheck::kReport.
  const std::vector<std::string>& changed_rows() const { return changed_rows_; }

  /// Library exceptions become Errors.
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
  std::unique_ptr<ExrInputStream> stream_;  // of the file, and outlives it
  std::unique_ptr<Imf::MultiPartInputFile> file_;
  int tile_size_ = 1;
  BakedHeader header_;
  std::vector<BakedPart> parts_;
  std::unique_ptr<ExrChunks> chunks_;
  std::unique_ptr<RowChecksums> row_checksums_;  // none: the file has none
  bool is_content_checked_ = false;              // of such a file, whole
  std::vector<std::string> changed_rows_;
};

/// The checksum of docs/reference/file_format.md of a file whose rows come level by level, from the top.
class BakedRowHash {
 public:
  explicit BakedRowHash(const std::vector<BakedPart>& parts);

  /// The next rows of a part's level, interleaved. Different parts and levels may be added from different threads.
  void add(std::size_t part, int level, const float* values, std::size_t value_count);
  std::string finish();

 private:
  std::vector<int> first_levels_;                 // [part]
  std::vector<std::vector<ContentHash>> hashes_;  // [part][level of the part]
};

}  // namespace multum
