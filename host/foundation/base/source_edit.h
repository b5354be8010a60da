// SPDX-License-Identifier: Apache-2.0
// Edits the text of kernels and shaders so that a test can run them without the guard that it covers. The test then
// shows what happens without the guard (host/lab/selftest, tests/gl).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multum {

struct SourceEdit {
  std::string file;         // name of the kernel or shader without folder and suffix
  std::string text;         // text to replace; occurs at least once in the file
  std::string replacement;  // replaces every occurrence
};

/// Returns `source`, the text of `file`, with the edits for this file applied. Throws std::logic_error, which names the
/// file, if the text of an edit does not occur. In that case, the source was changed without the test.
std::string edited_source(std::string_view source, const std::string& file, const std::vector<SourceEdit>& edits);

}  // namespace multum
