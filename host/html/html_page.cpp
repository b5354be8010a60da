// SPDX-License-Identifier: Apache-2.0
#include "host/html/html_page.h"

#include <fmt/format.h>

namespace multum {
namespace {

// The colours of tools/demo_page.py.
constexpr const char* kPageStyle = R"(
:root { color-scheme: light dark; --back: #fdfdfb; --text: #1d2329; --soft: #5b6670; --line: #d5d9dc; --blank: #e4e7e9;
  --heat: #1b6ca8; --link: #1b5e96; }
@media screen and (prefers-color-scheme: dark) {
  :root { --back: #15191d; --text: #e3e7ea; --soft: #a0abb4; --line: #39424a; --blank: #5a646e; --heat: #4f9fdc;
    --link: #8cc5f2; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 76rem; padding: 1rem 1.2rem 3rem; background: var(--back); color: var(--text);
  font: 1rem/1.5 system-ui, sans-serif; }
h1 { margin: .3em 0; font-size: 1.7rem; overflow-wrap: anywhere; } h2 { margin: 2.2rem 0 .4rem; }
h3 { margin: 1.4rem 0 .3rem; overflow-wrap: anywhere; }
p, ul { max-width: 46rem; margin: .4rem 0; } a { color: var(--link); } .soft, figcaption { color: var(--soft); }
.three { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .7rem; align-items: start; }
.thumbs { display: flex; flex-wrap: wrap; gap: .9rem; align-items: end; } 
.thumbs figure { max-width: 24rem; } .thumbs figure img { image-rendering: auto; }
.charts { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(21rem, 100%), 1fr)); gap: 1.2rem; }
figure { margin: 0; min-width: 0; }
figure img { display: block; max-width: 100%; height: auto; background: var(--blank); image-rendering: pixelated; }
figcaption { font-size: .88rem; margin-top: .2rem; overflow-wrap: anywhere; } figcaption b { color: var(--text); }
.wide { overflow-x: auto; margin: .5rem 0; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: .92rem; }
th, td { padding: .22rem .5rem; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap;
  vertical-align: bottom; }
th.text, td.text { text-align: left; white-space: normal; }
th { color: var(--soft); font-weight: 600; white-space: normal; } td.best { font-weight: 700; }
@media (max-width: 40rem) { th, td { padding: .22rem .3rem; font-size: .85rem; } }
svg { display: block; width: 100%; max-width: 30rem; height: auto; print-color-adjust: exact; }
svg text { fill: var(--soft); font: 11px system-ui, sans-serif; } svg .value { fill: var(--text); }
svg .cell { fill: var(--heat); } svg .none { fill: none; stroke: var(--line); }
svg .shown { fill: none; stroke: var(--text); stroke-width: 2; }
@media print { body { max-width: none; padding: 0; font-size: 10pt; } figure, tr { break-inside: avoid; }
  h2, h3 { break-after: avoid; } figure img { print-color-adjust: exact; } }
)";

}  // namespace

std::string html_escaped(const std::string& text) {
  std::string html;
  for (const char c : text) {
    if (c == '&') html += "&amp;";
    else if (c == '<') html += "&lt;";
    else if (c == '>') html += "&gt;";
    else if (c == '"') html += "&quot;";
    else if (c == '\'') html += "&#39;";
    else html += c;
  }
  return html;
}

std::string html_table(const std::vector<HtmlColumn>& columns, const std::vector<HtmlRow>& rows,
                       const std::string& attributes) {
  std::string html = "<div class=\"wide\"><table" + attributes + ">\n<tr>";
  for (const HtmlColumn& column : columns)
    html += fmt::format("<th scope=\"col\"{}>{}</th>", column.is_text ? " class=\"text\"" : "", column.head);
  html += "</tr>\n";
  for (const HtmlRow& row : rows) {
    html += "<tr>";
    for (std::size_t c = 0; c < row.size(); ++c) {
      const bool is_best = row[c].starts_with('*');
      html += fmt::format("<td{}>{}</td>",
                          columns[c].is_text ? " class=\"text\""
                          : is_best          ? " class=\"best\""
                                             : "",
                          is_best ? row[c].substr(1) : row[c]);
    }
    html += "</tr>\n";
  }
  return html + "</table></div>\n";
}

std::string html_page(const std::string& title, const std::string& body, const std::string& more_style) {
  return "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
         "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>" +
         title + "</title><style>" + kPageStyle + more_style + "</style></head><body>\n<h1>" + title + "</h1>\n" +
         body + "</body></html>\n";
}

}  // namespace multum
