// SPDX-License-Identifier: Apache-2.0
// Provides the rows of a bake's levels. Rows are fitted in this run (RowOrigin itself), taken from an earlier run
// (ResumedRows), gathered from shares (GatheredRows), or taken from an older file (host/bakes/bake/region_bake.h).
// ShareRows also fits the rows of a share in this run, and keeps them for the merge.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/bakes/movmf/level_rows.h"
#include "host/bakes/movmf/map_shard.h"
#include "host/bakes/movmf/row_records.h"
#include "host/bakes/pyramid/row_store.h"
#include "host/bakes/pyramid/row_window.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/foundation/base/files/spill_policy.h"

namespace multum {

/// Receives the results of a bake as floats. The rows of a level arrive in order from the first row, and coarse levels
/// arrive first. Rows of level 0 arrive between rows of level 1.
class MovmfSink {
 public:
  virtual ~MovmfSink() = default;
  virtual void add_level(int level, int first_row, MovmfLevel rows) = 0;
  virtual void add_finest(int first_row, MovmfFinest rows) = 0;
};

/// A level of a bake.
struct LevelShape {
  int level, height;
  std::size_t lobe_row_bytes;     // [lobe][column]
  std::size_t feature_row_bytes;  // [triple][lobe][column]; 0 if there are no features
  bool is_refined;                // true if the stored lobes differ from the lobes from which finer levels grow
  bool is_parent;                 // true if the next level is fitted

  RowBytes row_bytes() const { return {lobe_row_bytes, feature_row_bytes, is_refined ? lobe_row_bytes : 0}; }
};

/// The work to do for a level.
struct LevelTask {
  int rows_there = 0;      // rows [0, rows_there) already exist and can be read
  LevelRows fitted, kept;  // rows to fit, and the part of them to keep; the rest is needed only to fit finer levels
};

/// Fitted rows of a level, in the layout of LevelShape.
struct DoneRows {
  int first_row, row_count;
  const void *lobes, *features, *stored;
};

class RowOrigin {
 public:
  /// `sink` receives finished rows and must outlive the object. If it is null, the process that gathers the rows
  /// finishes them. `spill` states where rows from which finer levels grow are stored.
  RowOrigin(MovmfSink* sink, SpillPolicy spill) : sink_(sink), spill_(std::move(spill)) {}
  virtual ~RowOrigin() = default;
  RowOrigin(const RowOrigin&) = delete;
  RowOrigin& operator=(const RowOrigin&) = delete;

  MovmfSink* sink() const { return sink_; }
  /// Returns the texels of a level to fit, or nullopt for all texels. Other texels keep their lobes.
  virtual std::optional<TexelRange> range(int) const { return std::nullopt; }

  // Call begin() and end() for one level after another, the coarsest first.

  virtual LevelTask begin(const LevelShape& level);
  /// Reads rows of the level that already exist.
  void read(RowPart part, int first_row, int row_count, void* rows) {
    there_.read(level_.level, part, first_row, row_count, rows);
  }
  /// Sets the lobes of the level before it is fitted. Texels without a parent and texels in range() start from these
  /// lobes.
  void start_from(RowStore lobes) { before_ = std::move(lobes); }
  RowWindow::Fill before() const { return before_ ? fill_planes(*before_) : nullptr; }
  /// Lobes of the previous level.
  virtual RowWindow::Fill parent() { return fill_planes(*coarser_); }
  /// Receives fitted rows in order. This function is called from a different thread than the other members, but never
  /// during end().
  virtual void keep(const DoneRows& rows);
  virtual void end();

  /// Called after all levels.
  virtual void finish() {}
  /// Called if the bake is stopped and may be resumed. Keeps the files that are needed for resuming.
  virtual void leave() {}
  /// Number of rows that were taken from an earlier run.
  virtual std::uint64_t rows_resumed() const { return 0; }

 protected:
  LevelShape level_{};
  std::optional<RowStore> own_, coarser_, before_;  // lobes of this level if needed, of the coarser level, and of this
                                                    // level before the fit
  RowRecords there_;                                // rows of an earlier run, or of shares

  MovmfSink* const sink_;
  const SpillPolicy spill_;
};

/// Reuses rows of a killed run, and stores new rows for a later run, in the hidden folder next to the output.
class ResumedRows : public RowOrigin {
 public:
  /// `key` identifies the sources and settings on which rows depend. If `resume` is true, keeps existing rows of the
  /// same bake and removes all other rows. If `has_finest` is true, also stores rows of the finest fitted level.
  /// Returns null if another process is baking the same output. Throws Error(kEnvironment).
  static std::unique_ptr<ResumedRows> open(MovmfSink* sink, const SpillPolicy& spill, const std::string& output,
                                           const std::string& key, bool resume, bool has_finest);

  LevelTask begin(const LevelShape& level) override;
  RowWindow::Fill parent() override;
  void keep(const DoneRows& rows) override;
  void end() override { coarser_level_ = level_; }
  void leave() override { journal_->leave(); }
  std::uint64_t rows_resumed() const override { return rows_resumed_; }

 private:
  using RowOrigin::RowOrigin;
  bool keeps_level() const { return level_.is_parent || has_finest_; }

  std::unique_ptr<RecordJournal> journal_;
  bool has_finest_ = false;
  LevelShape coarser_level_{};
  std::uint64_t rows_resumed_ = 0;
};

/// Takes all rows from shares.
class GatheredRows : public RowOrigin {
 public:
  /// Reads shares 0 to `count` of `output`, whose rows depend on `key`. Throws Error(kEnvironment) that lists every
  /// share that is missing or belongs to another bake.
  GatheredRows(MovmfSink* sink, const std::string& output, int count, const std::string& key);

  /// Throws Error(kEnvironment) if rows of the level are missing in the shares.
  LevelTask begin(const LevelShape& level) override;
  void end() override {}

 private:
  const std::string output_;
  std::vector<std::unique_ptr<ShareFile>> shares_;
};

/// Fits one process's share of a map.
class ShareRows : public RowOrigin {
 public:
  /// `writer` receives the rows. A band needs share 0 of `output`, whose rows depend on `key`. Throws as ShareFile
  /// does.
  ShareRows(const SpillPolicy& spill, const MapShard& shard, ShardPlan plan, const std::string& output,
            const std::string& key, ShareWriter& writer);

  LevelTask begin(const LevelShape& level) override;
  void keep(const DoneRows& rows) override;

 private:
  RowStore rows_of_coarse_share();

  const MapShard shard_;
  const ShardPlan plan_;
  ShareWriter& writer_;
  std::optional<ShareFile> coarse_;
  LevelRows kept_{};
};

}  // namespace multum
