// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/html/html_page.h"

#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

std::string both(const std::string& name, std::string_view own) {
  const std::string text = std::string(html_templates().at(name)) + std::string(own);
  MULTUM_CHECK(text.find("</script") == std::string::npos && text.find("<!--") == std::string::npos);
  return text;
}

}  // namespace

// Without '<', the text cannot contain "</script" or "<!--", which could end or change the element. Because non-ASCII
// characters are escaped, U+2028 cannot end a line.
std::string script_json(const nlohmann::ordered_json& data) {
  std::string html;
  for (const char c : json_text(data, -1, true))
    if (c == '<') html += "\\u003c";
    else html += c;
  return html;
}

std::string html_page(const PageTemplate& page, const nlohmann::ordered_json& data) {
  const std::map<std::string, std::string> parts = {{"style", both("page.css", page.style)},
                                                    {"body", std::string(page.body)},
                                                    {"data", script_json(data)},
                                                    {"script", both("page.js", page.script)}};
  // Placeholders such as "{{style}}" are replaced only in the frame, because the parts may contain braces.
  const std::string_view frame = html_templates().at("page.html");
  std::string html;
  std::size_t at = 0;
  for (std::size_t open = frame.find("{{"); open != std::string_view::npos; open = frame.find("{{", at)) {
    const std::size_t close = frame.find("}}", open);
    MULTUM_CHECK(close != std::string_view::npos);
    html += frame.substr(at, open - at);
    html += parts.at(std::string(frame.substr(open + 2, close - open - 2)));
    at = close + 2;
  }
  return html + std::string(frame.substr(at));
}

}  // namespace multum
