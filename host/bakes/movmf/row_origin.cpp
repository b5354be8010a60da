// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/row_origin.h"

#include <algorithm>
#include <vector>

#include "host/foundation/base/error.h"

namespace multum {

LevelTask RowOrigin::begin(const LevelShape& level) {
  level_ = level;
  if (level.is_parent) own_.emplace(level.height, level.lobe_row_bytes, spill_);
  return {0, {0, level.height}, {0, level.height}};
}

void RowOrigin::read(RowPart, int, int, void*) { MULTUM_CHECK(false); }  // none are there

void RowOrigin::keep(const DoneRows& rows) {
  if (own_) own_->write(rows.first_row, rows.row_count, rows.lobes);
}

void RowOrigin::end() {
  coarser_ = std::exchange(own_, std::nullopt);
  before_.reset();
}

LevelTask ResumedRows::begin(const LevelShape& level) {
  level_ = level;
  kept_ = nullptr;
  if (level.is_parent || has_finest_)
    kept_ = &checkpoint_->open_level(level.level, level.height,
                                     {level.lobe_row_bytes, level.feature_row_bytes, level.is_refined});
  const int rows_there = kept_ != nullptr ? kept_->rows_done : 0;
  return {rows_there, {rows_there, level.height}, {rows_there, level.height}};
}

void ResumedRows::read(RowPart part, int first_row, int row_count, void* rows) {
  (part == RowPart::kFeatures ? *kept_->features : kept_->stored()).read(first_row, row_count, rows);
}

void ResumedRows::keep(const DoneRows& rows) {
  if (kept_ != nullptr) checkpoint_->add_rows(level_.level, rows.row_count, {rows.lobes, rows.features, rows.stored});
}

LevelTask GatheredRows::begin(const LevelShape& level) {
  level_ = level;
  return {level.height, {}, {}};
}

void GatheredRows::read(RowPart part, int first_row, int row_count, void* rows) {
  if (part == RowPart::kFeatures) shares_.read_features(level_.level, first_row, row_count, rows);
  else shares_.read_lobes(level_.level, first_row, row_count, rows);
}

LevelTask ShareRows::begin(const LevelShape& level) {
  level_ = level;
  const bool is_coarse = level.level >= plan_.coarse_from;
  if (is_coarse != (shard_.index == 0)) {
    if (level.level == plan_.coarse_from) own_ = rows_of_coarse_share();
    return {};
  }
  LevelTask task = RowOrigin::begin(level);
  if (!is_coarse) {
    task.fitted = plan_.fitted.at(level.level);
    task.kept = plan_.kept.at(level.level);
    // Windows reach beyond what is fitted, and read there what nobody wrote.
    if (own_) own_->write(level.height - 1, 1, std::vector<unsigned char>(level.lobe_row_bytes).data());
  }
  kept_ = task.kept;
  return task;
}

// All of them to the store that the next level grows from, those that count to the share.
void ShareRows::keep(const DoneRows& rows) {
  const auto row_of = [](const void* values, std::size_t row_bytes, int row) {
    return static_cast<const unsigned char*>(values) + row_bytes * static_cast<std::size_t>(row);
  };
  if (own_)
    for_each_piece(rows.first_row, rows.row_count, level_.height, [&](int first, int count, int at) {
      own_->write(first, count, row_of(rows.lobes, level_.lobe_row_bytes, at));
    });
  const LevelRows counted = common_rows({rows.first_row, rows.first_row + rows.row_count}, kept_);
  if (counted.begin >= counted.end) return;
  const int at = counted.begin - rows.first_row;
  writer_.add_rows(level_.level, counted.begin, counted.end - counted.begin, level_.lobe_row_bytes,
                   row_of(rows.lobes, level_.lobe_row_bytes, at), level_.feature_row_bytes,
                   row_of(rows.features, level_.feature_row_bytes, at));
}

// The level as the coarse share has it.
RowStore ShareRows::rows_of_coarse_share() const {
  RowStore store(level_.height, level_.lobe_row_bytes, spill_);
  int count = 0;
  coarse_->read(level_.level, [&](const ShardReader::Rows& rows) {
    if (rows.lobe_row_bytes != level_.lobe_row_bytes || rows.first_row != count ||
        rows.row_count > level_.height - count)
      throw Error(ErrorCode::kEnvironment,
                  "the share of coarse levels has other rows than it should; --force makes it");
    store.write(rows.first_row, rows.row_count, rows.lobes);
    count += rows.row_count;
  });
  if (count != level_.height)
    throw Error(ErrorCode::kEnvironment, "the share of coarse levels has not all of its rows; --force makes it");
  return store;
}

}  // namespace multum
