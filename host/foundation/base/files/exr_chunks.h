// SPDX-License-Identifier: Apache-2.0
// Finds the chunks of an OpenEXR file (its tiles or blocks of rows), checks their positions, and unpacks them. For a
// damaged chunk that is too short, OpenEXR 3.1 returns uninitialized memory without an error.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/foundation/base/files/byte_file.h"

namespace multum {

struct ExrChannel {
  std::string name;
  int type;  // kUint, kHalf or kFloat
  int x_sampling, y_sampling;

  static constexpr int kUint = 0, kHalf = 1, kFloat = 2;
  std::int64_t bytes() const { return type == kHalf ? 2 : 4; }
};

/// The texels that a chunk holds. Rows and columns are counted within its level, from the corner of the data window.
struct ExrChunkArea {
  int level_x, level_y;  // equal except in ripmaps
  int tile_x, tile_y;    // position of the tile; if the part is not tiled, 0 and the index of the block
  int x, y, width, height;
};

struct ExrChunkPlace {
  std::int64_t position;  // position of the packed bytes
  std::int32_t size;      // number of packed bytes, at least 1, all within the file
};

struct ExrLevel {
  int level_x, level_y, width, height;
  int columns, rows;        // numbers of chunks
  std::size_t first_chunk;  // index into ExrPart::chunks, which lists chunks row by row
};

/// The header fields on which the chunks of a part depend, and the chunks in the order of the part's chunk table.
struct ExrPart {
  std::string name;                         // empty for the only part of a file, which has no name
  std::vector<ExrChannel> channels;         // channels in the order of the file
  int x = 0, y = 0, width = 0, height = 0;  // data window
  int compression = 0;
  bool is_tiled = false;
  int chunk_width = 0, chunk_height = 0;  // texels per side; chunks at the right and bottom edges are smaller
  std::vector<ExrLevel> levels;
  std::vector<ExrChunkPlace> chunks;
};

/// Several threads may call this function at once.
class ExrChunks {
 public:
  /// Reads the headers and tables of the file, and the beginning of every chunk. Messages begin with `damaged`.
  /// `first_levels` (one per part; empty means 0) are added to the level numbers in messages. Throws Error(kInput),
  /// which names the file, part, level and tile, if a chunk is not at the position in its table, overlaps another
  /// chunk, or has an impossible size.
  explicit ExrChunks(const std::string& path, std::vector<int> first_levels = {}, std::string damaged = "damaged");

  const std::vector<ExrPart>& parts() const { return parts_; }
  ExrChunkArea area(std::size_t part, std::size_t chunk) const;
  /// Returns the number of bytes of the chunk after unpacking.
  std::int64_t unpacked_bytes(std::size_t part, std::size_t chunk) const;
  /// Returns whether unpack() can unpack the part, which must be uncompressed or packed by RLE, ZIPS or ZIP.
  bool can_unpack(std::size_t part) const;
  /// Unpacks the texels of the chunk in little-endian order, row by row, and within each row channel by channel. Writes
  /// all unpacked_bytes() bytes to `unpacked`, or throws Error(kInput). can_unpack() must be true.
  void unpack(std::size_t part, std::size_t chunk, std::vector<unsigned char>& unpacked) const;
  /// Unpacks every chunk with a known compression, to find chunks that are too short. For other compressions, the
  /// library itself detects short chunks.
  void check_all(int threads) const;
  /// Like check_all(), but only for chunks of the part's first level that hold rows from `first` up to, but not
  /// including, `end`. Rows are counted from the first row of the data window.
  void check_rows(std::size_t part, int first, int end, int threads) const;
  [[noreturn]] void refuse(std::size_t part, std::size_t chunk, const std::string& what) const;

 private:
  void read_headers();
  void read_table(std::size_t part, std::int64_t& position);
  void check_overlaps() const;
  const unsigned char* packed_bytes(std::size_t part, std::size_t chunk) const;  // valid until this thread's next call
  void check(std::size_t part, std::size_t chunk) const;
  void check_range(std::size_t part, std::size_t first, std::size_t end, int threads) const;

  const std::string path_;
  const std::vector<int> first_levels_;
  const std::string damaged_;
  mutable ByteFile file_;  // after construction, it is only read by position
  bool is_multi_part_ = false;
  std::int64_t tables_begin_ = 0, tables_end_ = 0;
  std::vector<ExrPart> parts_;
};

/// Advice at the end of each message about a damaged file.
constexpr char kWriteAnew[] = "The file was changed or is incomplete: copy or write it again";

}  // namespace multum
