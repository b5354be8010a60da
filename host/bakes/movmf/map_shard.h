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

#include <array>
#include <map>
#include <optional>
#include <string>

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/level_rows.h"
#include "host/bakes/movmf/mip_schedule.h"
#include "host/bakes/movmf/row_records.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/record_file.h"

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

/// The file of a share that is written: it appears when all is there. Its records are a note, what a reader shall know;
/// rows (host/bakes/movmf/row_records.h); and one without bytes at the end.
class ShareWriter {
 public:
  /// `key`: what the rows depend on; a line. Throws Error(kEnvironment), as the rest does.
  ShareWriter(const std::string& path, const std::string& key, const std::string& note);
  /// `parts`: see RowRecords::add().
  void add_rows(const RowBlock& rows, const std::array<const void*, 3>& parts) { rows_.add(records_, rows, parts); }
  void commit();

 private:
  AtomicFile file_;
  RecordFile records_;
  RowRecords rows_;
};

/// The file of a share that is there.
class ShareFile {
 public:
  /// Takes its rows to `rows`, which it must outlive. `key`: null: whatever it is of. `output`: as shard_path() has it.
  /// Throws Error(kEnvironment) that names the file, why it is of no use (it is not there, cut, or of another bake),
  /// and the share that makes it anew.
  ShareFile(const std::string& output, const MapShard& shard, const std::string* key, RowRecords& rows);
  const std::string& note() const { return note_; }
  const std::string& path() const { return path_; }

 private:
  [[noreturn]] void refuse(const std::string& why) const;
  bool take(const RecordFile::Place& place, RowRecords& rows);

  const std::string path_, remedy_;
  std::optional<RecordFile> records_;
  std::string note_;
  int record_count_ = 0;
  bool is_whole_ = false;
};

/// Is the share there, whole but for its rows, and of this bake?
bool has_shard(const std::string& output, const MapShard& shard, const std::string& key);

/// Removes the files of shares 0 to `count`.
void remove_shards(const std::string& output, int count);

}  // namespace multum
