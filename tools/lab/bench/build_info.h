// SPDX-License-Identifier: Apache-2.0
// States what was built and how it was built, so that measurements can be repeated. Every build updates this
// information (write_build_info.cmake).
#pragma once

#include <string>

namespace multum::bench {

/// Returns the abbreviated commit, or "unknown" outside a repository. Appends "-dirty" if tracked files other than
/// documents differed from the commit.
std::string built_commit();

std::string compiler_name();  // such as "GNU 12.2.0, Release"

}  // namespace multum::bench
