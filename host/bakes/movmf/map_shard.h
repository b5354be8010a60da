// SPDX-License-Identifier: Apache-2.0
// Divides the fit of one map's lobes among processes: a first share fits the coarse levels, which need the whole map,
// each of the others a band of rows of every finer level. A texel needs what lies a few rows around it and its parents,
// so that a band is fitted with some rows more on either side, more on coarser levels, which are done again and
// dropped:
//
//   level 3     [  ######  ]        [ ]  fitted
//   level 2      [ ###### ]         ###  kept
//   level 1       [######]
//
// What is kept equals what one process fits, bit for bit (movmf_level_fit.h).
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/level_rows.h"
#include "host/bakes/movmf/mip_schedule.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/output_file.h"
#include "host/foundation/base/files/scratch_file.h"

namespace multum {

/// Share 0 has the coarse levels; shares 1 to `count`, at least 2, have bands.
struct MapShard {
  int index = 0, count = 2;
  bool operator==(const MapShard&) const = default;
};

/// "3/8" or "0/8". Throws Error(kUsage) that names `option`.
MapShard parse_map_shard(const std::string& option, const std::string& text);

struct ShardPlan {
  int coarse_from = 0;  // the finest of the coarse levels
  // Of a band, for each finer level that is fitted, down to the finest.
  std::map<int, LevelRows> kept, fitted;
};

/// Throws Error(kUsage) where the map is too small for so many bands, or its levels do not follow one another.
ShardPlan plan_shard(const MipSchedule& schedule, const MovmfSettings& settings, const MapShard& shard);

/// Rows of the map that a band's levels cover, and those beside them that windows may hold. Of a map that repeats they
/// may lie beyond its borders.
LevelRows map_rows(const ShardPlan& plan, const MipSchedule& schedule, const MovmfSettings& settings);

/// The file of a share, beside the output: OUTPUT.shard-3-of-8.
std::string shard_path(const std::string& output, const MapShard& shard);

/// Rows of levels of a share, some at a time as they are fitted, in a file that appears when all are there:
///
///   rows; then text: the key; a note; and a line for each block of rows, in order: level, first row, rows, bytes of a
///   row of lobes, bytes of a row of features, CRC-64 of the block; the bytes of that text, 8 of them, little-endian;
///   "multum shard 3\n"
///
/// A block is rows [lobe][column] of lobes, then rows [triple][lobe][column] of features.
class ShardWriter {
 public:
  /// `key`: what the rows depend on; `note`: what a reader shall know; a line each. Throws Error(kEnvironment), as the
  /// rest does.
  ShardWriter(const std::string& path, const std::string& key, const std::string& note);
  /// `features`: null where rows of them have 0 bytes.
  void add_rows(int level, int first_row, int row_count, std::size_t lobe_row_bytes, const void* lobes,
                std::size_t feature_row_bytes, const void* features);
  void commit();

 private:
  void write(const void* bytes, std::size_t count);

  AtomicFile file_;
  OutputFile out_;
  std::string text_;  // behind the rows
};

/// The rows of a share that is there.
class ShardReader {
 public:
  /// Throws Error(kEnvironment) that names the file, why it is of no use (it is not there, cut, or of another bake),
  /// and the share that makes it anew. `output`: as shard_path() has it.
  ShardReader(const std::string& output, const MapShard& shard, const std::string& key);

  struct Rows {
    int level = 0, first_row = 0, row_count = 0;
    std::size_t lobe_row_bytes = 0, feature_row_bytes = 0;
    const void* lobes = nullptr;
    const void* features = nullptr;  // null: none
    std::int64_t begin = 0;          // in the file
  };
  /// The note of a share that is there, whatever it is of; else "".
  static std::string note_of(const std::string& output, const MapShard& shard);
  const std::string& note() const { return note_; }
  std::size_t block_count() const { return blocks_.size(); }
  /// What a block is of, without its rows; and them, lobes first, in the place of what `bytes` holds.
  const Rows& block(std::size_t number) const { return blocks_.at(number).rows; }
  void read_block(std::size_t number, std::string& bytes);
  /// Calls `take` with all rows of a level, in order, or with the blocks that some of `rows` are in. Throws as the
  /// constructor does where they are damaged.
  void read(int level, const std::function<void(const Rows&)>& take);
  void read(int level, const LevelRows& rows, const std::function<void(const Rows&)>& take);

 private:
  struct Block {
    Rows rows;
    std::string checksum;
  };
  ShardReader(const std::string& output, const MapShard& shard, const std::string* key);
  [[noreturn]] void refuse(const std::string& why) const;
  void read_table(ByteFile file, const std::string* key);

  const std::string path_, remedy_;
  std::optional<ScratchFile> rows_;
  std::string bytes_;  // of the block that is handed over
  std::vector<Block> blocks_;
  std::string note_;
};

/// Is the share there, whole but for its rows, and of this bake?
bool has_shard(const std::string& output, const MapShard& shard, const std::string& key);

}  // namespace multum
