// SPDX-License-Identifier: Apache-2.0
// Rejects figures that were measured with uncommitted sources, because nobody could repeat the measurement
// (tools/lab/committed_tree.py does the same for Python).
#pragma once

#include <string>

namespace multum::bench {

/// Describes the commit at which the figures of a document were measured. If `commit` (build_info.h) is unknown or ends
/// in "-dirty", throws an Error(kUsage) that begins with `what`. With `allow_dirty`, does not throw, and the text
/// states that the sources are uncommitted.
std::string stated_commit(const std::string& what, const std::string& commit, bool allow_dirty);

}  // namespace multum::bench
