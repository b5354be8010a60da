// SPDX-License-Identifier: Apache-2.0
// Writes Markdown tables with padded columns, so that they are also readable on a terminal.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

class MarkdownTable {
 public:
  explicit MarkdownTable(std::vector<std::string> head) : rows_{std::move(head)} {}

  /// Adds a row with as many cells as the head.
  void add(std::vector<std::string> row);
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;  // all rows, starting with the head
};

/// Describes the default filter, which is used to measure pixel errors: "4 taps, which are averaged and shaded once, at
/// a level bias of -0.5".
std::string default_filter_text();

}  // namespace multum::bench
