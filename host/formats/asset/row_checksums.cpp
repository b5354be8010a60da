// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/row_checksums.h"

#include <fmt/format.h>

#include "host/foundation/base/files/checksum.h"

namespace multum {
namespace {

constexpr std::size_t kRowDigits = 16;

std::string row_checksum(const float* values, std::size_t count) {
  Checksum checksum;
  checksum.update(values, count * sizeof(float));
  return checksum.text();
}

}  // namespace

RowChecksums::RowChecksums(const BakedHeader& header, const std::vector<BakedPart>& parts, int tile_size)
    : text_(fmt::format("{:>5} ", tile_size)) {
  std::size_t end = text_.size();
  for (const BakedPart& part : parts) {
    first_levels_.push_back(part.first_level);
    std::vector<std::size_t>& levels = places_.emplace_back();
    for (int l = part.first_level; l < part.first_level + part.level_count; ++l) {
      levels.push_back(end);
      const int rows = (mip_level_size(header.height, l) + tile_size - 1) / tile_size;
      end += kRowDigits * static_cast<std::size_t>(rows);
    }
  }
  text_.resize(end, ' ');
}

bool RowChecksums::take(const std::string& text) {
  const std::size_t head = text_.find_last_not_of(' ') + 2;  // length of "  128 "
  if (text.size() != text_.size() || text.compare(0, head, text_, 0, head) != 0) return false;
  text_ = text;
  return true;
}

std::size_t RowChecksums::place(std::size_t part, int level, int tile_row) const {
  return places_[part][static_cast<std::size_t>(level - first_levels_[part])] +
         kRowDigits * static_cast<std::size_t>(tile_row);
}

void RowChecksums::set(std::size_t part, int level, int tile_row, const float* values, std::size_t count) {
  text_.replace(place(part, level, tile_row), kRowDigits, row_checksum(values, count));
}

bool RowChecksums::is_same(std::size_t part, int level, int tile_row, const float* values, std::size_t count) const {
  return text_.compare(place(part, level, tile_row), kRowDigits, row_checksum(values, count)) == 0;
}

}  // namespace multum
