// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/documents/markdown_table.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/formats/asset/tap_filter.h"
#include "host/foundation/base/error.h"

namespace multum::bench {

void MarkdownTable::add(std::vector<std::string> row) {
  MULTUM_CHECK(row.size() == rows_[0].size());
  rows_.push_back(std::move(row));
}

std::string MarkdownTable::text() const {
  std::vector<std::size_t> widths(rows_[0].size(), 3);
  for (const std::vector<std::string>& row : rows_)
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  std::string text;
  for (std::size_t r = 0; r < rows_.size(); ++r) {
    for (std::size_t i = 0; i < widths.size(); ++i) text += fmt::format("| {:<{}} ", rows_[r][i], widths[i]);
    text += "|\n";
    if (r > 0) continue;
    for (const std::size_t width : widths) text += "|" + std::string(width + 2, '-');
    text += "|\n";
  }
  return text;
}

std::string default_filter_text() {
  return fmt::format("{} taps, which are {}, at a level bias of {:g}", kTapCountDefault,
                     kShadesTapsDefault ? "shaded separately" : "averaged and shaded once", kLevelBiasDefault);
}

}  // namespace multum::bench
