// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/movmf/row_records.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <span>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::uint64_t kBlockBytes = std::uint64_t{4} << 20;
constexpr std::int32_t kRowsMax = 3 * 32768;  // largest row count; the three planes of a map have separate rows

std::uint64_t sum(const RowBytes& bytes) { return std::accumulate(bytes.begin(), bytes.end(), std::uint64_t{0}); }

bool is_in_order(const RowBlock& rows) {
  return rows.first_row >= 0 && rows.first_row <= kRowsMax && rows.row_count >= 1 && rows.row_count <= kRowsMax &&
         *std::max_element(rows.row_bytes.begin(), rows.row_bytes.end()) <= std::uint64_t{1} << 32;
}

}  // namespace

void RowRecords::add(RecordFile& file, const RowBlock& rows, const std::array<const void*, 3>& parts) {
  const auto most = static_cast<std::int32_t>(std::clamp<std::uint64_t>(kBlockBytes / sum(rows.row_bytes), 1, 1 << 20));
  for (int row = 0; row < rows.row_count; row += most) {
    RowBlock block = rows;
    block.first_row += row;
    block.row_count = std::min(most, rows.row_count - row);
    const auto part = [&](std::size_t p) {
      if (rows.row_bytes[p] == 0) return RecordFile::Bytes();
      return RecordFile::Bytes(
          static_cast<const std::uint8_t*>(parts[p]) + rows.row_bytes[p] * static_cast<unsigned>(row),
          rows.row_bytes[p] * static_cast<unsigned>(block.row_count));
    };
    const RecordFile::Bytes head(reinterpret_cast<const std::uint8_t*>(&block), sizeof(block));
    found_[rows.level].push_back({block, &file, file.add({head, part(0), part(1), part(2)}), nullptr});
  }
}

bool RowRecords::take(const RecordFile& file, const RecordFile::Place& place, const std::string* remedy) {
  RowBlock rows;
  if (place.size < sizeof(rows) || !file.read(place.offset, {reinterpret_cast<std::uint8_t*>(&rows), sizeof(rows)}) ||
      !is_in_order(rows) ||
      place.size != sizeof(rows) + sum(rows.row_bytes) * static_cast<std::uint64_t>(rows.row_count))
    return false;
  found_[rows.level].push_back({rows, &file, place, remedy});
  return true;
}

int RowRecords::row_count(int level, const RowBytes& row_bytes) {
  std::vector<Found>& found = found_[level];
  int count = 0;
  const auto other = std::find_if(found.begin(), found.end(), [&](const Found& one) {
    if (one.rows.first_row != count || one.rows.row_bytes != row_bytes) return true;
    count += one.rows.row_count;
    return false;
  });
  found.erase(other, found.end());
  return count;
}

std::uint64_t RowRecords::begin_of(int level) const {
  const auto found = found_.find(level);
  return found == found_.end() || found->second.empty() ? 0 : found->second[0].place.offset + sizeof(RowBlock);
}

const RowRecords::Found& RowRecords::load(int level, int row) {
  const std::vector<Found>& found = found_[level];
  const auto behind = std::upper_bound(found.begin(), found.end(), row,
                                       [](int at, const Found& one) { return at < one.rows.first_row; });
  MULTUM_CHECK(behind != found.begin());
  const Found& one = *(behind - 1);
  MULTUM_CHECK(row < one.rows.first_row + one.rows.row_count);
  if (place_ != one.place.offset || file_ != one.file) {
    file_ = nullptr;
    if (!one.file->read(one.place, bytes_))
      throw Error(
          ErrorCode::kEnvironment,
          fmt::format("{}: rows {} to {} of level {} are damaged{}", one.file->shown_path(), one.rows.first_row,
                      one.rows.first_row + one.rows.row_count - 1, level, one.remedy != nullptr ? *one.remedy : ""));
    file_ = one.file;
    place_ = one.place.offset;
  }
  return one;
}

void RowRecords::read(int level, RowPart part, int first_row, int row_count, void* rows) {
  auto* to = static_cast<std::uint8_t*>(rows);
  for (int row = first_row; row < first_row + row_count;) {
    const RowBlock& block = load(level, row).rows;
    auto p = static_cast<std::size_t>(part);
    if (part == RowPart::kStored && block.row_bytes[p] == 0) p = static_cast<std::size_t>(RowPart::kLobes);
    const int count = std::min(first_row + row_count, block.first_row + block.row_count) - row;
    std::uint64_t at = sizeof(RowBlock);
    for (std::size_t before = 0; before < p; ++before)
      at += block.row_bytes[before] * static_cast<std::uint64_t>(block.row_count);
    at += block.row_bytes[p] * static_cast<std::uint64_t>(row - block.first_row);
    const std::uint64_t bytes = block.row_bytes[p] * static_cast<std::uint64_t>(count);
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(at), bytes, to);
    to += bytes;
    row += count;
  }
}

}  // namespace multum
