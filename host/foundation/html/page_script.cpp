// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/html/page_script.h"

#include <algorithm>

#include "host/foundation/base/error.h"

namespace multum {

std::string plain_script(std::string_view module_text) {
  std::string script;
  bool is_import = false;
  for (std::size_t begin = 0; begin < module_text.size();) {
    const std::size_t end = std::min(module_text.find('\n', begin), module_text.size() - 1) + 1;
    const std::string_view line = module_text.substr(begin, end - begin);
    begin = end;
    if (line.starts_with("import ")) is_import = true;
    if (!is_import) script += line.starts_with("export ") ? line.substr(7) : line;
    if (is_import && line.find(" from \"") != std::string_view::npos) is_import = false;
  }
  return script;
}

void check_script(const std::string& script) {
  MULTUM_CHECK(script.find("</script") == std::string::npos && script.find("<!--") == std::string::npos);
}

}  // namespace multum
