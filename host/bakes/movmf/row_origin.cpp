// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/row_origin.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum {

LevelTask RowOrigin::begin(const LevelShape& level) {
  level_ = level;
  if (level.is_parent) own_.emplace(level.height, level.lobe_row_bytes, spill_);
  return {0, {0, level.height}, {0, level.height}};
}

void RowOrigin::keep(const DoneRows& rows) {
  if (own_) own_->write(rows.first_row, rows.row_count, rows.lobes);
}

void RowOrigin::end() {
  coarser_ = std::exchange(own_, std::nullopt);
  before_.reset();
}

std::unique_ptr<ResumedRows> ResumedRows::open(MovmfSink* sink, const SpillPolicy& spill, const std::string& output,
                                               const std::string& key, bool resume, bool has_finest) {
  std::unique_ptr<ResumedRows> origin(new ResumedRows(sink, spill));
  std::vector<RecordFile::Place> places;
  origin->journal_ =
      RecordJournal::open(output, "progress", key, resume, [&](RecordFile::Bytes, const RecordFile::Place& place) {
        places.push_back(place);
        return true;
      });
  if (origin->journal_ == nullptr) return nullptr;
  for (const RecordFile::Place& place : places) origin->there_.take(*origin->journal_, place);
  origin->has_finest_ = has_finest;
  return origin;
}

LevelTask ResumedRows::begin(const LevelShape& level) {
  level_ = level;
  const int count = keeps_level() ? std::min(there_.row_count(level.level, level.row_bytes()), level.height) : 0;
  rows_resumed_ += static_cast<std::uint64_t>(count);
  return {count, {count, level.height}, {count, level.height}};
}

RowWindow::Fill ResumedRows::parent() {
  return fill_planes(coarser_level_.height, coarser_level_.lobe_row_bytes,
                     [this, level = coarser_level_.level](int first_row, int row_count, void* rows) {
                       there_.read(level, RowPart::kLobes, first_row, row_count, rows);
                     });
}

void ResumedRows::keep(const DoneRows& rows) {
  if (keeps_level())
    there_.add(*journal_, {level_.level, rows.first_row, rows.row_count, 0, level_.row_bytes()},
               {rows.lobes, rows.features, rows.stored});
}

GatheredRows::GatheredRows(MovmfSink* sink, const std::string& output, int count, const std::string& key)
    : RowOrigin(sink, SpillPolicy{}), output_(output) {
  std::string missing;
  for (int i = 0; i <= count; ++i) {
    try {
      shares_.push_back(std::make_unique<ShareFile>(output, MapShard{i, count}, &key, there_));
    } catch (const Error& error) {
      missing += (missing.empty() ? "" : "\n  ") + std::string(error.what());
    }
  }
  if (!missing.empty()) throw Error(ErrorCode::kEnvironment, missing);
}

LevelTask GatheredRows::begin(const LevelShape& level) {
  level_ = level;
  if (there_.row_count(level.level, level.row_bytes()) != level.height)
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: its shares do not contain the rows of level {}; --force computes them again", output_,
                            level.level));
  return {level.height, {}, {}};
}

ShareRows::ShareRows(const SpillPolicy& spill, const MapShard& shard, ShardPlan plan, const std::string& output,
                     const std::string& key, ShareWriter& writer)
    : RowOrigin(nullptr, spill), shard_(shard), plan_(std::move(plan)), writer_(writer) {
  if (shard.index > 0) coarse_.emplace(output, MapShard{0, shard.count}, &key, there_);
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
    // Extends the file to its full length, because windows also read rows beyond the fitted rows, which were never
    // written.
    if (own_) own_->write(level.height - 1, 1, std::vector<unsigned char>(level.lobe_row_bytes).data());
  }
  kept_ = task.kept;
  return task;
}

// Writes all rows to the store from which the next level grows, and the kept rows to the share.
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
  writer_.add_rows(
      {level_.level, counted.begin, counted.end - counted.begin, 0, level_.row_bytes()},
      {row_of(rows.lobes, level_.lobe_row_bytes, at), row_of(rows.features, level_.feature_row_bytes, at), nullptr});
}

// Returns the rows of the level from the coarse share.
RowStore ShareRows::rows_of_coarse_share() {
  if (there_.row_count(level_.level, level_.row_bytes()) != level_.height)
    throw Error(
        ErrorCode::kEnvironment,
        "the share of the coarse levels lacks rows, or its rows have the wrong size; --force computes the share again");
  RowStore store(level_.height, level_.lobe_row_bytes, spill_);
  std::vector<unsigned char> row(level_.lobe_row_bytes);
  for (int y = 0; y < level_.height; ++y) {
    read(RowPart::kLobes, y, 1, row.data());
    store.write(y, 1, row.data());
  }
  return store;
}

}  // namespace multum
