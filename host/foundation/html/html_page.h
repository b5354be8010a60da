// SPDX-License-Identifier: Apache-2.0
// Makes pages of HTML out of templates (host/foundation/html/templates) and data: one file each, which opens from disk
// and needs nothing else. A page's script renders the data, which are a block of JSON in it.
#pragma once

#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace multum {

/// What a page has beside the style and the helpers (templates/page.js) that all have. Texts may hold no "</script".
struct PageTemplate {
  std::string_view body;    // HTML behind the title
  std::string_view style;   // CSS
  std::string_view script;  // JavaScript; `data` is parsed, and its "title" is shown, when it begins
};

/// `data` may hold any text of strangers: it reaches the page as data, and its script makes text nodes of it.
std::string html_page(const PageTemplate& page, const nlohmann::ordered_json& data);

/// JSON that may stand in a script element: nothing of it can end or change the element.
std::string script_json(const nlohmann::ordered_json& data);

/// The files of host/foundation/html/templates, by name. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& html_templates();

}  // namespace multum
