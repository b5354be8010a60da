// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/map_shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <regex>
#include <vector>

#include "host/bakes/movmf/movmf_level_fit.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/work_shard.h"

namespace multum {
namespace {

constexpr int kCountMax = 4096;

// Returns the rows that contain the parents of rows [begin, end) of the finer level, plus one row on either side.
LevelRows parents_of(const LevelRows& rows) {
  const auto half = [](int row) { return row >= 0 ? row / 2 : (row - 1) / 2; };
  return {half(rows.begin) - 1, half(rows.end - 1) + 2};
}

// Returns the rows that LevelFit fits and reads to finish some rows.
LevelRows reach(const LevelRows& rows, int steps) { return {rows.begin - steps, rows.end + steps}; }

LevelRows band(int height, const MapShard& shard) {
  const auto edge = [&](int k) { return static_cast<int>(std::int64_t{height} * k / shard.count); };
  return {edge(shard.index - 1), edge(shard.index)};
}

// A band needs about the same number of extra rows on every level, so the ratio of extra rows to kept rows doubles with
// each coarser level. This ratio may be at most a half on the coarsest divided level, a quarter on the next finer
// level, and so on. On the finest level, the ratio may be 1, because nothing can be divided without this level.
bool is_worth_dividing(const LevelSchedule& level, const LevelRows& fitted, int steps, int count, bool is_finest) {
  const int height = level.fit.height, rows = fitted.end - fitted.begin + 2 * (steps - 1);
  return rows + 2 < height && 2 * rows * count <= (is_finest ? 4 : 3) * height + 2 * count;
}

bool can_be_divided(const LevelSchedule& level) {
  return level.order == FitOrder::kColour && level.fit.parent_width > 0 &&
         (level.method == FitMethod::kChoice || level.method == FitMethod::kTexels);
}

}  // namespace

MapShard parse_map_shard(const std::string& option, const std::string& text) {
  static const std::regex kForm(R"((\d{1,4})/(\d{1,4}))");
  std::smatch found;
  if (std::regex_match(text, found, kForm)) {
    const MapShard shard{std::stoi(found[1]), std::stoi(found[2])};
    if (2 <= shard.count && shard.count <= kCountMax && shard.index <= shard.count) return shard;
  }
  throw Error(ErrorCode::kUsage, fmt::format("{} is '{}', expected a share I/N of one map, such as 0/8 for the coarse "
                                             "levels or 1/8 to 8/8 for the bands, with N from 2 to {}",
                                             option, text, kCountMax));
}

ShardPlan plan_shard(const MipSchedule& schedule, const MovmfSettings& settings, const MapShard& shard) {
  if (!settings.aligned_start)
    throw Error(ErrorCode::kUsage,
                "--shard is given with unaligned lobes, expected aligned lobes, because levels of unaligned lobes do "
                "not depend on each other");
  ShardPlan plan;
  // All shares must divide the same levels, so the levels are determined for a band in the middle of the map.
  LevelRows middle_before{}, own_before{};
  int steps_before = 0;
  bool is_first = true;
  for (auto level = schedule.levels.rbegin(); level != schedule.levels.rend(); ++level) {
    const int steps = fit_steps(*level, settings), height = level->fit.height;
    const LevelRows middle_band{0, (height + shard.count - 1) / shard.count};
    LevelRows middle = middle_band, own = shard.index > 0 ? band(height, shard) : LevelRows{};
    const LevelRows kept = own;
    if (!is_first) {
      const auto extend = [&](LevelRows& rows, const LevelRows& finer) {
        const LevelRows parents = parents_of(reach(finer, steps_before));
        rows = {std::min(rows.begin, parents.begin), std::max(rows.end, parents.end)};
      };
      extend(middle, middle_before);
      extend(own, own_before);
    }
    plan.coarse_from = level->level;
    if (!can_be_divided(*level) || !is_worth_dividing(*level, middle, steps, shard.count, is_first)) break;
    plan.coarse_from = level->level + 1;
    if (level->fit.periodic_y == 0) own = {std::max(own.begin, 0), std::min(own.end, height)};
    plan.kept[level->level] = kept;
    plan.fitted[level->level] = own;
    middle_before = middle;
    own_before = own;
    steps_before = steps;
    is_first = false;
  }
  if (is_first)
    throw Error(ErrorCode::kUsage,
                fmt::format("--shard has {} bands, expected fewer, because the finest fitted level has only {} rows or "
                            "the settings do not allow bands",
                            shard.count, schedule.levels.empty() ? 0 : schedule.levels.back().fit.height));
  return plan;
}

LevelRows map_rows(const ShardPlan& plan, const MipSchedule& schedule, const MovmfSettings& settings) {
  LevelRows rows{schedule.levels.front().fit.map_height, 0};
  bool repeats = false;
  for (const LevelSchedule& level : schedule.levels) {
    const auto fitted = plan.fitted.find(level.level);
    if (fitted == plan.fitted.end()) continue;
    const LevelRows read = reach(fitted->second, fit_steps(level, settings) + 1);
    rows.begin = std::min(rows.begin, first_covered_row(level.fit, read.begin));
    rows.end = std::max(rows.end, last_covered_row(level.fit, read.end));
    repeats = level.fit.periodic_y != 0;
  }
  const int height = schedule.levels.front().fit.map_height;
  if (rows.end - rows.begin >= height) return {0, height};
  return repeats ? rows : LevelRows{std::max(rows.begin, 0), std::min(rows.end, height)};
}

std::string shard_path(const std::string& output, const MapShard& shard) {
  return share_file(output, shard.index, shard.count);
}

ShareWriter::ShareWriter(const std::string& path, const std::string& key, const std::string& note)
    : file_(path), records_(file_) {
  records_.begin(key);
  records_.add({RecordFile::bytes_of(note)});
}

void ShareWriter::commit() {
  records_.add({});
  file_.commit();
}

ShareFile::ShareFile(const std::string& output, const MapShard& shard, const std::string* key, RowRecords& rows)
    : path_(shard_path(output, shard)), remedy_(fmt::format("; --shard {}/{} makes it", shard.index, shard.count)) {
  if (!std::filesystem::is_regular_file(path_)) refuse("does not exist");
  records_.emplace(path_);
  std::uint64_t end = 0;
  try {
    end = records_->visit_records(key, [&](const RecordFile::Place& place) { return take(place, rows); });
  } catch (const Error& error) {
    throw Error(ErrorCode::kEnvironment, error.what() + remedy_);
  }
  if (end == 0) refuse("belongs to another map, other settings, or another version of multum");
  if (!is_whole_) refuse("is incomplete or damaged");
}

// Rows are checked later, when they are read.
bool ShareFile::take(const RecordFile::Place& place, RowRecords& rows) {
  const bool is_note = record_count_++ == 0;
  is_whole_ = false;
  if (!is_note && place.size > 0) return rows.take(*records_, place, &remedy_);
  std::vector<std::uint8_t> bytes;
  if (!records_->read(place, bytes)) return false;
  if (is_note) note_.assign(bytes.begin(), bytes.end());
  else is_whole_ = true;
  return true;
}

void ShareFile::refuse(const std::string& why) const {
  throw Error(ErrorCode::kEnvironment, fmt::format("{}: {}{}", path_, why, remedy_));
}

bool has_shard(const std::string& output, const MapShard& shard, const std::string& key) {
  try {
    RowRecords rows;
    const ShareFile file(output, shard, &key, rows);
    return true;
  } catch (const Error&) {
    return false;
  }
}

void remove_shards(const std::string& output, int count) {
  std::error_code ignored;
  for (int i = 0; i <= count; ++i) std::filesystem::remove(shard_path(output, {i, count}), ignored);
}

}  // namespace multum
