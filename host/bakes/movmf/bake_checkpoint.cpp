// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/bake_checkpoint.h"

#include <fmt/format.h>

#include <sstream>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/checksum.h"

namespace multum {
namespace {

constexpr std::size_t kLineMax = 256;  // bytes of a line of progress

}  // namespace

std::unique_ptr<BakeCheckpoint> BakeCheckpoint::open(const std::string& output, const std::string& key, bool resume) {
  std::unique_ptr<WorkFolder> folder = WorkFolder::take(partial_folder_of(output));
  if (folder == nullptr) return nullptr;
  if (!resume) folder->clear();
  return std::unique_ptr<BakeCheckpoint>(new BakeCheckpoint(std::move(folder), key, resume));
}

BakeCheckpoint::BakeCheckpoint(std::unique_ptr<WorkFolder> folder, const std::string& key, bool resume)
    : folder_(std::move(folder)), progress_(*folder_, "progress") {
  const std::uint64_t bytes = resume ? read_progress(key) : 0;
  progress_.cut(found_.empty() ? 0 : bytes);
  if (!found_.empty()) return;
  folder_->clear("progress");
  progress_.append_line(key);
}

// A line that a kill or a full disk has torn, and what follows a damaged one, does not count.
std::uint64_t BakeCheckpoint::read_progress(const std::string& key) {
  if (progress_.line(0, key.size()) != key) return 0;
  std::uint64_t good = key.size() + 1;
  while (const std::optional<std::string> line = progress_.line(good, kLineMax)) {
    std::istringstream words(*line);
    int level = 0;
    Block block{0, 0, ""};
    if (!(words >> level >> block.first_row >> block.row_count >> block.checksum) || block.checksum.size() != 16) break;
    found_[level].push_back(block);
    good += line->size() + 1;
  }
  return good;
}

std::string BakeCheckpoint::block_checksum(const Level& level, int first_row, int row_count) {
  Checksum checksum;
  const auto add = [&](const RowStore& store) {
    std::vector<unsigned char> bytes(store.row_bytes() * static_cast<std::size_t>(row_count));
    store.read(first_row, row_count, bytes.data());
    checksum.update(bytes.data(), bytes.size());
  };
  add(level.lobes);
  if (level.features) add(*level.features);
  if (level.refined) add(*level.refined);
  return checksum.text();
}

BakeCheckpoint::Level& BakeCheckpoint::open_level(int level, int row_count, const RowBytes& row_bytes) {
  const std::string name = "level-" + std::to_string(level);
  Level& opened =
      levels_.try_emplace(level, Level{RowStore(row_count, row_bytes.lobes, *folder_, name + ".lobes"), {}, {}, 0})
          .first->second;
  if (row_bytes.features > 0) opened.features.emplace(row_count, row_bytes.features, *folder_, name + ".features");
  if (row_bytes.is_refined) opened.refined.emplace(row_count, row_bytes.lobes, *folder_, name + ".refined");
  for (const Block& block : found_[level]) {
    if (block.first_row != opened.rows_done || block.row_count < 1 || block.row_count > row_count - block.first_row)
      break;
    try {
      if (block_checksum(opened, block.first_row, block.row_count) != block.checksum) break;
    } catch (const Error&) {
      break;  // the file ends before the block does
    }
    opened.rows_done += block.row_count;
  }
  rows_resumed_ += static_cast<std::uint64_t>(opened.rows_done);
  return opened;
}

void BakeCheckpoint::add_rows(int level, int row_count, const Rows& rows) {
  Level& done = levels_.at(level);
  Checksum checksum;
  const auto add = [&](RowStore& store, const void* values) {
    store.write(done.rows_done, row_count, values);
    checksum.update(values, store.row_bytes() * static_cast<std::size_t>(row_count));
  };
  add(done.lobes, rows.lobes);
  if (done.features) add(*done.features, rows.features);
  if (done.refined) add(*done.refined, rows.refined);
  progress_.append_line(fmt::format("{} {} {} {}", level, done.rows_done, row_count, checksum.text()));
  done.rows_done += row_count;
}

}  // namespace multum
