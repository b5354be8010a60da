// SPDX-License-Identifier: Apache-2.0
// Edits of kernel and shader texts, so that a case can be run with the guard that it is about taken out: what happens
// without it is then shown and not asserted (host/lab/selftest, tests/gl).
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace multum {

struct SourceEdit {
  std::string file;         // name of the kernel or shader without folder and suffix
  std::string text;         // as it stands there, at least once
  std::string replacement;  // of every occurrence
};

/// `source`, the text of `file`, after those edits that are for it. Throws std::logic_error, which names it,
/// for a text that does not occur: the source moved on without the case.
std::string edited_source(std::string_view source, const std::string& file, const std::vector<SourceEdit>& edits);

}  // namespace multum
