// SPDX-License-Identifier: Apache-2.0
#include "host/asset/movmf_mipmap.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/base/error.h"

namespace multum {

const char* storage_encoding_name(StorageEncoding encoding) {
  switch (encoding) {
    case StorageEncoding::kSnorm16: return "snorm16";
    case StorageEncoding::kHalf: return "half";
    case StorageEncoding::kFloat: return "float";
  }
  return "?";
}

int mip_level_count(int width, int height) {
  int count = 1;
  for (int side = std::max(width, height); side > 1; side >>= 1) ++count;
  return count;
}

MovmfLevel rows_of(const MovmfLevel& level, int first_row, int row_count) {
  MULTUM_CHECK(first_row >= 0 && row_count >= 0 && first_row + row_count <= level.height);
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(first_row) * level.width;
  const std::ptrdiff_t end = first + static_cast<std::ptrdiff_t>(row_count) * level.width;
  MovmfLevel rows{level.width, row_count, {}, {}};
  for (const auto& lobe : level.lobes) rows.lobes.emplace_back(lobe.begin() + first, lobe.begin() + end);
  for (const auto& colour : level.colours) rows.colours.emplace_back(colour.begin() + first, colour.begin() + end);
  return rows;
}

std::string levels_text(const MovmfMipmap& mipmap) {
  const std::size_t count = mipmap.levels.size();
  if (mipmap.first_level == 0) return fmt::format("{} levels", count);
  const int coarsest = static_cast<int>(count) - 1;
  if (mipmap.first_level == coarsest) return fmt::format("level {} of 0 to {}", coarsest, coarsest);
  return fmt::format("levels {} to {} of 0 to {}", mipmap.first_level, coarsest, coarsest);
}

void drop_finer_levels(MovmfMipmap& mipmap, int first_level) {
  MULTUM_CHECK(first_level >= mipmap.first_level && first_level < static_cast<int>(mipmap.levels.size()));
  for (int l = 0; l < first_level; ++l) {
    MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    for (auto& lobe : level.lobes) lobe = std::vector<glm::vec4>();  // = {} would keep the memory
    for (auto& colour : level.colours) colour = std::vector<glm::vec3>();
  }
  mipmap.first_level = first_level;
}

}  // namespace multum
