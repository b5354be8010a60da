// SPDX-License-Identifier: Apache-2.0
// Shares the parts of the project's HTML pages: one style that reads in light, in dark and on paper, text made safe,
// tables.
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Text between tags, or in an attribute.
std::string html_escaped(const std::string& text);

struct HtmlColumn {
  std::string head;  // HTML, as cells are
  bool is_text = false;
};

using HtmlRow = std::vector<std::string>;

/// Cells that begin with '*' are the best of their column. `attributes`: of the table, as " class=\"sortable\"".
std::string html_table(const std::vector<HtmlColumn>& columns, const std::vector<HtmlRow>& rows,
                       const std::string& attributes = "");

/// A whole page; `title` and `body` are HTML, `more_style` is CSS.
std::string html_page(const std::string& title, const std::string& body, const std::string& more_style = "");

}  // namespace multum
