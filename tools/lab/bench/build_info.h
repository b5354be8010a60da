// SPDX-License-Identifier: Apache-2.0
// States what was built and how, so that measurements can be repeated. Every build writes it anew
// (write_build_info.cmake).
#pragma once

#include <string>

namespace multum::bench {

/// The abbreviated commit. "-dirty" is appended if tracked files, except for documents, differed from it. "unknown"
/// outside a repository.
std::string built_commit();

std::string compiler_name();  // "GNU 12.2.0, Release"

}  // namespace multum::bench
