// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/map_shard.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <regex>
#include <sstream>

#include "host/bakes/movmf/movmf_level_fit.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/checksum.h"
#include "host/foundation/base/work_shard.h"

namespace multum {
namespace {

constexpr char kMagic[] = "multum shard 3\n";  // the file's end
constexpr std::int64_t kMagicBytes = sizeof(kMagic) - 1, kLengthBytes = 8;
constexpr int kCountMax = 4096;
constexpr int kRowsMax = 32768;  // of a map
constexpr std::size_t kBlockBytes = std::size_t{4} << 20;

// Rows of a level that the parents of rows [begin, end) of the finer one are among, with one more on either side.
LevelRows parents_of(const LevelRows& rows) {
  const auto half = [](int row) { return row >= 0 ? row / 2 : (row - 1) / 2; };
  return {half(rows.begin) - 1, half(rows.end - 1) + 2};
}

// What LevelFit fits and reads to hand over some rows.
LevelRows reach(const LevelRows& rows, int steps) { return {rows.begin - steps, rows.end + steps}; }

LevelRows band(int height, const MapShard& shard) {
  const auto edge = [&](int k) { return static_cast<int>(std::int64_t{height} * k / shard.count); };
  return {edge(shard.index - 1), edge(shard.index)};
}

// Rows around a band are about as many on every level, so that each coarser level has twice the share of rows that are
// fitted again: the coarsest that is divided at most half as many as are kept, the next finer one a quarter, and so on.
// The finest level, without which nothing is divided, may have as many again as are kept.
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
  throw Error(
      ErrorCode::kUsage,
      fmt::format("{} is '{}', expected I/N of one map: 0/8 for its coarse levels, then 1/8 to 8/8; N from 2 to "
                  "{}",
                  option, text, kCountMax));
}

ShardPlan plan_shard(const MipSchedule& schedule, const MovmfSettings& settings, const MapShard& shard) {
  if (!settings.aligned_start)
    throw Error(ErrorCode::kUsage, "--shard is given with unaligned lobes, whose levels do not follow one another");
  ShardPlan plan;
  // Which levels are divided must not depend on which share asks: the rows of one in the middle decide.
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
    throw Error(
        ErrorCode::kUsage,
        fmt::format("--shard has {} bands, expected fewer: the finest level that is fitted has {} rows, too few "
                    "for so many bands, or settings that know of no bands",
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

ShardWriter::ShardWriter(const std::string& path, const std::string& key, const std::string& note)
    : file_(path), out_(file_), text_(key + "\n" + note + "\n") {}

void ShardWriter::write(const void* bytes, std::size_t count) {
  if (!out_.write(bytes, count)) out_.close();  // throws
}

void ShardWriter::add_rows(int level, int first_row, int row_count, std::size_t lobe_row_bytes, const void* lobes,
                           std::size_t feature_row_bytes, const void* features) {
  // Whoever reads a row holds its block.
  const auto rows_a_block =
      static_cast<int>(std::max<std::size_t>(1, kBlockBytes / (lobe_row_bytes + feature_row_bytes)));
  for (int row = 0; row < row_count; row += rows_a_block) {
    const int count = std::min(rows_a_block, row_count - row);
    Checksum checksum;
    const auto add = [&](const void* rows, std::size_t row_bytes) {
      const std::size_t bytes = row_bytes * static_cast<std::size_t>(count);
      if (bytes == 0) return;
      const auto* begin = static_cast<const unsigned char*>(rows) + row_bytes * static_cast<std::size_t>(row);
      checksum.update(begin, bytes);
      write(begin, bytes);
    };
    add(lobes, lobe_row_bytes);
    add(features, feature_row_bytes);
    text_ += fmt::format("{} {} {} {} {} {}\n", level, first_row + row, count, lobe_row_bytes, feature_row_bytes,
                         checksum.text());
  }
}

void ShardWriter::commit() {
  write(text_.data(), text_.size());
  unsigned char length[kLengthBytes];
  for (std::size_t i = 0; i < sizeof(length); ++i)
    length[i] = static_cast<unsigned char>(std::uint64_t{text_.size()} >> (8 * i));
  write(length, sizeof(length));
  write(kMagic, static_cast<std::size_t>(kMagicBytes));
  out_.close();
  file_.commit();
}

ShardReader::ShardReader(const std::string& output, const MapShard& shard, const std::string& key)
    : ShardReader(output, shard, &key) {}

ShardReader::ShardReader(const std::string& output, const MapShard& shard, const std::string* key)
    : path_(shard_path(output, shard)), remedy_(fmt::format("--shard {}/{}", shard.index, shard.count)) {
  try {
    read_table(ByteFile(path_), key);
    rows_.emplace(ScratchFile::to_read(path_));
  } catch (const Error& error) {
    if (error.code() == ErrorCode::kEnvironment) throw;
    refuse("is not there, or is cut");
  }
}

void ShardReader::read_table(ByteFile file, const std::string* key) {
  const std::int64_t table_end = file.size() - kMagicBytes - kLengthBytes;
  if (table_end < 0 || file.bytes(file.size() - kMagicBytes, kMagicBytes, "the end") != kMagic)
    refuse("is no share of a bake, or is cut");
  const std::int64_t length = file.little_endian(table_end, kLengthBytes, "the length of the table");
  if (length < 1 || length > table_end) refuse("has no table of its rows");
  const std::int64_t rows_end = table_end - length;
  std::istringstream lines(file.bytes(rows_end, length, "the table"));
  std::string line;
  if (!std::getline(lines, line) || (key != nullptr && line != *key))
    refuse("is of another map, other settings, or another version of multum");
  std::getline(lines, note_);
  std::int64_t at = 0;
  while (std::getline(lines, line)) {
    std::istringstream words(line);
    Block block;
    Rows& rows = block.rows;
    if (!(words >> rows.level >> rows.first_row >> rows.row_count >> rows.lobe_row_bytes >> rows.feature_row_bytes >>
          block.checksum) ||
        rows.first_row < 0 || rows.first_row > kRowsMax || rows.row_count < 1 || rows.row_count > kRowsMax ||
        rows.lobe_row_bytes > std::size_t{1} << 32 || rows.feature_row_bytes > std::size_t{1} << 32)
      refuse("has a damaged table");
    rows.begin = at;
    at += static_cast<std::int64_t>(rows.lobe_row_bytes + rows.feature_row_bytes) * rows.row_count;
    if (at > rows_end) refuse("has a damaged table");
    blocks_.push_back(std::move(block));
  }
  if (at != rows_end) refuse("has a damaged table");
}

void ShardReader::read(int level, const std::function<void(const Rows&)>& take) {
  read(level, {0, std::numeric_limits<int>::max()}, take);
}

void ShardReader::read(int level, const LevelRows& wanted, const std::function<void(const Rows&)>& take) {
  for (const Block& block : blocks_) {
    if (block.rows.level != level || block.rows.first_row >= wanted.end ||
        block.rows.first_row + block.rows.row_count <= wanted.begin)
      continue;
    Rows rows = block.rows;
    read_block(static_cast<std::size_t>(&block - blocks_.data()), bytes_);
    rows.lobes = bytes_.data();
    if (rows.feature_row_bytes > 0)
      rows.features = bytes_.data() + rows.lobe_row_bytes * static_cast<std::size_t>(rows.row_count);
    take(rows);
  }
}

std::string ShardReader::note_of(const std::string& output, const MapShard& shard) {
  try {
    return ShardReader(output, shard, nullptr).note_;
  } catch (const Error&) {
    return "";
  }
}

void ShardReader::read_block(std::size_t number, std::string& bytes) {
  const Block& block = blocks_.at(number);
  const Rows& rows = block.rows;
  bytes.resize((rows.lobe_row_bytes + rows.feature_row_bytes) * static_cast<std::size_t>(rows.row_count));
  rows_->read(static_cast<std::uint64_t>(rows.begin), bytes.data(), bytes.size());
  Checksum checksum;
  checksum.update(bytes.data(), bytes.size());
  if (checksum.text() != block.checksum)
    refuse(fmt::format("has damaged rows, {} to {} of level {}", rows.first_row, rows.first_row + rows.row_count - 1,
                       rows.level));
}

void ShardReader::refuse(const std::string& why) const {
  throw Error(ErrorCode::kEnvironment, fmt::format("{}: {}; {} makes it", path_, why, remedy_));
}

bool has_shard(const std::string& output, const MapShard& shard, const std::string& key) {
  try {
    ShardReader(output, shard, key);
    return true;
  } catch (const Error&) {
    return false;
  }
}

}  // namespace multum
