// SPDX-License-Identifier: Apache-2.0
// Refuses to make documents of figures that were measured with sources that are not committed: nobody could make them
// again (tools/lab/committed_tree.py does the same for Python).
#pragma once

#include <string>

namespace multum::bench {

/// What a document says of the commit its figures are of. Throws Error(kUsage) where `commit` (build_info.h) is none or
/// ends in "-dirty", beginning with `what`, unless `allow_dirty`: then the text says that too.
std::string stated_commit(const std::string& what, const std::string& commit, bool allow_dirty);

}  // namespace multum::bench
