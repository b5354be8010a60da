// SPDX-License-Identifier: Apache-2.0
// Origins of the rows of a bake's levels: fitted now (RowOrigin itself), taken from an earlier run (ResumedRows),
// gathered from shares (GatheredRows), or from the file that a part is fitted onto (host/bakes/bake/region_bake.h). A
// share of a map (ShareRows) is fitted now as well, and its rows are kept for whoever gathers them.
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

/// Takes what a bake makes, exact to float: rows of a level in order from its first, coarse levels first, but rows of
/// level 0 between those of level 1.
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
  std::size_t feature_row_bytes;  // [triple][lobe][column]; 0: none
  bool is_refined;                // what the file stores differs from what finer levels grow from
  bool is_parent;                 // of a level that is fitted

  RowBytes row_bytes() const { return {lobe_row_bytes, feature_row_bytes, is_refined ? lobe_row_bytes : 0}; }
};

/// What is to be done of a level.
struct LevelTask {
  int rows_there = 0;      // rows [0, rows_there) are there to be read
  LevelRows fitted, kept;  // rows to fit; those among them that count, the others are what finer rows grow from
};

/// Rows of a level that are fitted, as LevelShape says.
struct DoneRows {
  int first_row, row_count;
  const void *lobes, *features, *stored;
};

class RowOrigin {
 public:
  /// `sink`: takes finished rows, and outlives this; null: whoever gathers the rows finishes them. `spill`: of rows
  /// that finer levels grow from.
  RowOrigin(MovmfSink* sink, SpillPolicy spill) : sink_(sink), spill_(std::move(spill)) {}
  virtual ~RowOrigin() = default;
  RowOrigin(const RowOrigin&) = delete;
  RowOrigin& operator=(const RowOrigin&) = delete;

  MovmfSink* sink() const { return sink_; }
  /// The texels of a level that are fitted, where others stay as they are. Nothing: all.
  virtual std::optional<TexelRange> range(int) const { return std::nullopt; }

  // Levels begin and end one after another, the coarsest first.

  virtual LevelTask begin(const LevelShape& level);
  /// Rows of the level that are there.
  void read(RowPart part, int first_row, int row_count, void* rows) {
    there_.read(level_.level, part, first_row, row_count, rows);
  }
  /// Lobes that the level has before it is fitted: texels without a parent start from them, those in range() as well.
  void start_from(RowStore lobes) { before_ = std::move(lobes); }
  RowWindow::Fill before() const { return before_ ? fill_planes(*before_) : nullptr; }
  /// Lobes of the level before.
  virtual RowWindow::Fill parent() { return fill_planes(*coarser_); }
  /// Takes rows that were fitted, in order. In another thread than the other calls, but none comes at the same time as
  /// end().
  virtual void keep(const DoneRows& rows);
  virtual void end();

  /// All levels are done.
  virtual void finish() {}
  /// The bake is stopped and may go on: what is kept for it stays.
  virtual void leave() {}
  /// Rows of texels that were there from an earlier run.
  virtual std::uint64_t rows_resumed() const { return 0; }

 protected:
  LevelShape level_{};
  std::optional<RowStore> own_, coarser_, before_;  // lobes: of this level where finer ones need them, and of the last
  RowRecords there_;                                // of an earlier run, or of shares

  MovmfSink* const sink_;
  const SpillPolicy spill_;
};

/// Rows that a killed run left are not fitted again, and others are left for the next, in the hidden folder beside the
/// output.
class ResumedRows : public RowOrigin {
 public:
  /// `key` stands for the sources and settings: everything that rows depend on. What is there of the same bake is kept
  /// when `resume`, anything else is removed. `has_finest`: rows of the finest level that is fitted are kept as well.
  /// Null while another process bakes the same output. Throws Error(kEnvironment).
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

/// All rows are in shares.
class GatheredRows : public RowOrigin {
 public:
  /// Shares 0 to `count` of `output`, whose rows depend on `key`. Throws Error(kEnvironment) that lists every share
  /// that is missing or of something else.
  GatheredRows(MovmfSink* sink, const std::string& output, int count, const std::string& key);

  /// Throws Error(kEnvironment) where they have not all of its rows.
  LevelTask begin(const LevelShape& level) override;
  void end() override {}

 private:
  const std::string output_;
  std::vector<std::unique_ptr<ShareFile>> shares_;
};

/// One process's share of a map.
class ShareRows : public RowOrigin {
 public:
  /// `writer` takes the rows. A band needs share 0 of `output`, whose rows depend on `key`: throws as ShareFile does.
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
