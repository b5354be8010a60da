// SPDX-License-Identifier: Apache-2.0
// Finds the chunks of an OpenEXR file, its tiles or blocks of rows, checks where they are, and unpacks them.
// OpenEXR 3.1 takes what a damaged chunk lacks from memory that nobody wrote, without a word.
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

/// Texels that a chunk holds. Rows and columns are those of its level, from 0 at the data window's corner.
struct ExrChunkArea {
  int level_x, level_y;  // the same, but of ripmaps
  int tile_x, tile_y;    // 0 and the block's number where rows are not tiled
  int x, y, width, height;
};

struct ExrChunkPlace {
  std::int64_t position;  // of its packed bytes
  std::int32_t size;      // at least 1, and all of it within the file
};

struct ExrLevel {
  int level_x, level_y, width, height;
  int columns, rows;        // of chunks
  std::size_t first_chunk;  // in ExrPart::chunks, which has them row by row
};

/// A part's header, as far as its chunks depend on it, and its chunks in the order of its table.
struct ExrPart {
  std::string name;                         // empty: the file has one part, without a name
  std::vector<ExrChannel> channels;         // as they lie in the file
  int x = 0, y = 0, width = 0, height = 0;  // data window
  int compression = 0;
  bool is_tiled = false;
  int chunk_width = 0, chunk_height = 0;  // texels a side; at the right and bottom chunks are smaller
  std::vector<ExrLevel> levels;
  std::vector<ExrChunkPlace> chunks;
};

/// Calls may come from several threads.
class ExrChunks {
 public:
  /// Reads headers and tables of the file, and the head of every chunk. `first_levels`: what is added to each part's
  /// levels in messages, 0 where it is empty; `damaged`: what they begin with. Throws Error(kInput) naming the file,
  /// part, level and tile: a chunk that is not where its table says, is empty, too short, too long or beyond the end of
  /// the file, or overlaps another.
  explicit ExrChunks(const std::string& path, std::vector<int> first_levels = {}, std::string damaged = "damaged");

  const std::vector<ExrPart>& parts() const { return parts_; }
  ExrChunkArea area(std::size_t part, std::size_t chunk) const;
  /// Bytes of the chunk once it is unpacked.
  std::int64_t unpacked_bytes(std::size_t part, std::size_t chunk) const;
  /// Is it stored as it is, or packed as unpack() can: by RLE, ZIPS or ZIP?
  bool can_unpack(std::size_t part) const;
  /// The chunk's texels: row by row, in each channel by channel, little-endian. All bytes of `unpacked` up to
  /// unpacked_bytes() are written, or Error(kInput) is thrown. Only where can_unpack().
  void unpack(std::size_t part, std::size_t chunk, std::vector<unsigned char>& unpacked) const;
  /// Unpacks every chunk that can be, to find those that are too short. Of others the library notices.
  void check_all(int threads) const;
  /// The same of those that hold rows of the part's first level, from `first` to before `end`, of the data window.
  void check_rows(std::size_t part, int first, int end, int threads) const;
  [[noreturn]] void refuse(std::size_t part, std::size_t chunk, const std::string& what) const;

 private:
  void read_headers();
  void read_table(std::size_t part, std::int64_t& position);
  void check_overlaps() const;
  const unsigned char* packed_bytes(std::size_t part, std::size_t chunk) const;  // until the thread's next call
  void check(std::size_t part, std::size_t chunk) const;
  void check_range(std::size_t part, std::size_t first, std::size_t end, int threads) const;

  const std::string path_;
  const std::vector<int> first_levels_;
  const std::string damaged_;
  mutable ByteFile file_;  // after the constructor only read by position
  bool is_multi_part_ = false;
  std::int64_t tables_begin_ = 0, tables_end_ = 0;
  std::vector<ExrPart> parts_;
};

/// What a refusal of a damaged file ends with: what to do.
constexpr char kWriteAnew[] = "The file was changed or not written whole: copy or write it anew";

}  // namespace multum
