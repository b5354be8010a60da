// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/texel_selection.h"

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum {

TexelSelection::TexelSelection(std::vector<PlaneSize> sizes, std::vector<std::vector<int>> texels)
    : sizes_(std::move(sizes)) {
  MULTUM_CHECK(texels.size() == sizes_.size());
  for (std::size_t level = 0; level < sizes_.size(); ++level) {
    std::vector<int>& chosen = texels[level];
    if (!std::is_sorted(chosen.begin(), chosen.end())) std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    const PlaneSize size = sizes_[level];
    MULTUM_CHECK(chosen.empty() || (chosen.front() >= 0 && chosen.back() / size.width < size.height));
    level_row_.push_back(row_begin_.size());
    std::size_t next = 0;
    for (int y = 0; y < size.height; ++y) {
      row_begin_.push_back(columns_.size());
      for (; next < chosen.size() && chosen[next] / size.width == y; ++next)
        columns_.push_back(chosen[next] % size.width);
    }
    chosen = {};
  }
  level_row_.push_back(row_begin_.size());
  row_begin_.push_back(columns_.size());
}

std::size_t TexelSelection::slot(int level, int texel) const {
  const int width = sizes_[static_cast<std::size_t>(level)].width;
  const int row = texel / width, column = texel % width;
  const std::size_t begin = row_begin(level, row), end = row_end(level, row);
  if (end - begin == static_cast<std::size_t>(width)) return begin + static_cast<std::size_t>(column);
  const auto first = columns_.begin();
  const auto found =
      std::lower_bound(first + static_cast<std::ptrdiff_t>(begin), first + static_cast<std::ptrdiff_t>(end), column);
  const auto slot = static_cast<std::size_t>(found - first);
  MULTUM_CHECK(slot < end && *found == column);
  return slot;
}

}  // namespace multum
