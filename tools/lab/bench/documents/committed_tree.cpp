// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/documents/committed_tree.h"

#include <fmt/format.h>

#include "host/foundation/base/error.h"

namespace multum::bench {

std::string stated_commit(const std::string& what, const std::string& commit, bool allow_dirty) {
  if (commit != "unknown" && !commit.ends_with("-dirty")) return "commit " + commit;
  if (!allow_dirty)
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: measured with the sources of commit {}, expected a committed tree, from which the same "
                    "figures can be made again. Commit, build and measure again, or use --allow-dirty, which "
                    "the document then states.",
                    what, commit));
  return fmt::format("commit {} (--allow-dirty: sources that are not committed)", commit);
}

}  // namespace multum::bench
