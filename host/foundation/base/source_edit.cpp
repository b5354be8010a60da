// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/source_edit.h"

#include <stdexcept>

namespace multum {

std::string edited_source(std::string_view source, const std::string& file, const std::vector<SourceEdit>& edits) {
  std::string result(source);
  for (const SourceEdit& edit : edits) {
    if (edit.file != file) continue;
    std::size_t at = result.find(edit.text);
    if (edit.text.empty() || at == std::string::npos)
      throw std::logic_error("nothing to edit in " + file + ": it does not hold '" + edit.text + "'");
    for (; at != std::string::npos; at = result.find(edit.text, at + edit.replacement.size()))
      result.replace(at, edit.text.size(), edit.replacement);
  }
  return result;
}

}  // namespace multum
