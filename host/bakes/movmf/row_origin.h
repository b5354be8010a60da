// SPDX-License-Identifier: Apache-2.0
// Where the rows of a bake's levels come from: fitted now (RowOrigin itself), taken from an earlier run (ResumedRows),
// gathered from shares (GatheredRows), or from the file that a part is fitted onto (host/bakes/bake/region_bake.h). A
// share of a map (ShareRows) is fitted now as well, and its rows are kept for whoever gathers them.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "host/bakes/movmf/bake_checkpoint.h"
#include "host/bakes/movmf/gathered_shards.h"
#include "host/bakes/movmf/level_rows.h"
#include "host/bakes/movmf/map_shard.h"
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
};

/// What is to be done of a level.
struct LevelTask {
  int rows_there = 0;      // rows [0, rows_there) are there to be read
  LevelRows fitted, kept;  // rows to fit; those among them that count, the others are what finer rows grow from
};

/// What rows hold: lobes that finer levels grow from, features, and lobes as the file stores them.
enum class RowPart { kLobes, kFeatures, kStored };

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
  /// Rows that are there.
  virtual void read(RowPart part, int first_row, int row_count, void* rows);
  /// Lobes that the level has before it is fitted: texels without a parent start from them, those in range() as well.
  void start_from(RowStore lobes) { before_ = std::move(lobes); }
  RowWindow::Fill before() const { return before_ ? fill_planes(*before_) : nullptr; }
  /// Lobes of the level before.
  virtual RowWindow::Fill parent() const { return fill_planes(*coarser_); }
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

  MovmfSink* const sink_;
  const SpillPolicy spill_;
};

/// Rows that a killed run left are not fitted again, and others are left for the next.
class ResumedRows : public RowOrigin {
 public:
  /// `has_finest`: rows of the finest level that is fitted are kept as well.
  ResumedRows(MovmfSink* sink, SpillPolicy spill, std::unique_ptr<BakeCheckpoint> checkpoint, bool has_finest)
      : RowOrigin(sink, std::move(spill)), checkpoint_(std::move(checkpoint)), has_finest_(has_finest) {}

  LevelTask begin(const LevelShape& level) override;
  void read(RowPart part, int first_row, int row_count, void* rows) override;
  RowWindow::Fill parent() const override { return fill_planes(coarser_kept_->lobes); }
  void keep(const DoneRows& rows) override;
  void end() override { coarser_kept_ = kept_; }
  void leave() override { checkpoint_->leave(); }
  std::uint64_t rows_resumed() const override { return checkpoint_->rows_resumed(); }

 private:
  const std::unique_ptr<BakeCheckpoint> checkpoint_;
  const bool has_finest_;
  BakeCheckpoint::Level *kept_ = nullptr, *coarser_kept_ = nullptr;
};

/// All rows are in shares.
class GatheredRows : public RowOrigin {
 public:
  GatheredRows(MovmfSink* sink, GatheredShards shares) : RowOrigin(sink, SpillPolicy{}), shares_(std::move(shares)) {}

  LevelTask begin(const LevelShape& level) override;
  void read(RowPart part, int first_row, int row_count, void* rows) override;
  void end() override {}

 private:
  GatheredShards shares_;
};

/// One process's share of a map.
class ShareRows : public RowOrigin {
 public:
  /// `coarse`: share 0, of any other one.
  ShareRows(SpillPolicy spill, const MapShard& shard, ShardPlan plan, ShardWriter& writer, ShardReader* coarse)
      : RowOrigin(nullptr, std::move(spill)), shard_(shard), plan_(std::move(plan)), writer_(writer), coarse_(coarse) {}

  LevelTask begin(const LevelShape& level) override;
  void keep(const DoneRows& rows) override;

 private:
  RowStore rows_of_coarse_share() const;

  const MapShard shard_;
  const ShardPlan plan_;
  ShardWriter& writer_;
  ShardReader* const coarse_;
  LevelRows kept_{};
};

}  // namespace multum
