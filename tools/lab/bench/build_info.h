// SPDX-License-Identifier: Apache-2.0
// States what was built, and how: measurements without it cannot be made again. Written anew at each build
// (write_build_info.cmake).
#pragma once

#include <string>

namespace multum::bench {

/// The commit, abbreviated; "-dirty" is appended when tracked files but documents differed from it; "unknown" outside a
/// repository.
std::string built_commit();

std::string compiler_name();  // "GNU 12.2.0, Release"

}  // namespace multum::bench
