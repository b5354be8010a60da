// SPDX-License-Identifier: Apache-2.0
// A Markdown table whose columns are padded, so that it reads as well on a terminal.
#pragma once

#include <string>
#include <vector>

namespace multum::bench {

class MarkdownTable {
 public:
  explicit MarkdownTable(std::vector<std::string> head) : rows_{std::move(head)} {}

  /// As many cells as the head has.
  void add(std::vector<std::string> row);
  std::string text() const;

 private:
  std::vector<std::vector<std::string>> rows_;  // the head first
};

/// The default filter, which errors of pixels are measured through: "4 taps, averaged and shaded once, at a bias of
/// -0.5".
std::string default_filter_text();

}  // namespace multum::bench
