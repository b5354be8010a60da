// SPDX-License-Identifier: Apache-2.0
// Divides the fit of one map's lobes among processes. The first share fits the coarse levels, which need the whole map.
// Each other share fits a band of rows of every finer level. A texel depends on a few rows around it and on its
// parents. A band is therefore fitted with extra rows on both sides, which cover a larger part of the map on coarser
// levels. The extra rows are dropped afterwards:
//
//   level 3     [  ######  ]        [ ]  fitted
//   level 2      [ ###### ]         ###  kept
//   level 1       [######]
//
// The kept rows are bit for bit equal to the rows that a single process would fit (movmf_level_fit.h).
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

/// Share 0 fits the coarse levels. Shares 1 to `count` fit bands; `count` is at least 2.
struct MapShard {
  int index = 0, count = 2;
  bool operator==(const MapShard&) const = default;
};

/// Parses "3/8" or "0/8". Throws Error(kUsage) that names `option`.
MapShard parse_map_shard(const std::string& option, const std::string& text);

struct ShardPlan {
  int coarse_from = 0;  // the finest of the coarse levels
  // Rows of a band on each finer level, down to the finest fitted level.
  std::map<int, LevelRows> kept, fitted;
};

/// Throws Error(kUsage) if the map is too small for this number of bands, or if levels are fitted independently.
ShardPlan plan_shard(const MipSchedule& schedule, const MovmfSettings& settings, const MapShard& shard);

/// Returns the rows of the map that the levels of a band cover, including rows that windows may hold. On a map that
/// repeats, these rows may be outside the borders.
LevelRows map_rows(const ShardPlan& plan, const MipSchedule& schedule, const MovmfSettings& settings);

/// Path of a share's file, which is next to the output: OUTPUT.shard-3-of-8.
std::string shard_path(const std::string& output, const MapShard& shard);

/// Writes the file of a share. The file appears when it is complete. Its records are a note for the processes that read
/// it, the rows (host/bakes/movmf/row_records.h), and an empty record at the end.
class ShareWriter {
 public:
  /// `key` is one line that identifies the inputs of the rows. All members throw Error(kEnvironment).
  ShareWriter(const std::string& path, const std::string& key, const std::string& note);
  /// For `parts`, see RowRecords::add().
  void add_rows(const RowBlock& rows, const std::array<const void*, 3>& parts) { rows_.add(records_, rows, parts); }
  void commit();

 private:
  AtomicFile file_;
  RecordFile records_;
  RowRecords rows_;
};

/// Reads the file of a finished share.
class ShareFile {
 public:
  /// Adds the file's rows to `rows`. The object must outlive `rows`. If `key` is null, any key is accepted. `output` is
  /// as for shard_path(). Throws Error(kEnvironment) that names the file, the problem (missing, cut off, or from
  /// another bake), and the share to bake again.
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

/// True if the share exists, belongs to this bake and is complete. Does not check its rows.
bool has_shard(const std::string& output, const MapShard& shard, const std::string& key);

/// Removes the files of shares 0 to `count`.
void remove_shards(const std::string& output, int count);

}  // namespace multum
