// SPDX-License-Identifier: Apache-2.0
#include "tests/unit/foundation/html/rendered_page.h"

#include "host/foundation/base/processes/child_process.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

void remove_elements(std::string& html, const std::string& name) {
  const std::string end = "</" + name + ">";
  for (std::size_t at = html.find("<" + name); at != std::string::npos; at = html.find("<" + name, at)) {
    const std::size_t close = html.find(end, at);
    if (close == std::string::npos) return;
    html.erase(at, close + end.size() - at);
  }
}

}  // namespace

nlohmann::json page_data(const std::string& page) {
  const std::string begin = "<script type=\"application/json\" id=\"data\">";
  const std::size_t at = page.find(begin), end = page.find("</script>", at);
  if (at == std::string::npos || end == std::string::npos) return nullptr;
  return nlohmann::json::parse(page.substr(at + begin.size(), end - at - begin.size()));
}

std::optional<std::string> rendered_page(const std::string& page) {
  const TemporaryFolder folder;
  write_bytes(folder / "page.html", page);
  // Chromium's profile and the messages that it always prints go into the folder.
  const ChildResult result = run_child(
      {"sh", "-c",
       "browser=$(command -v chromium-headless-shell || command -v chromium) || exit 127; HOME=\"$1\" exec "
       "\"$browser\" "
       "--headless --no-sandbox --disable-gpu --disable-dev-shm-usage --user-data-dir=\"$1/profile\" --dump-dom "
       "\"file://$1/page.html\" 2> \"$1/complaints\"",
       "sh", folder.path()});
  if (result.exit_code == 127) return std::nullopt;
  EXPECT_EQ(result.exit_code, 0) << read_bytes(folder / "complaints");
  std::string html = result.output;
  for (const char* name : {"script", "style", "noscript"}) remove_elements(html, name);
  return html;
}

}  // namespace multum::testing
