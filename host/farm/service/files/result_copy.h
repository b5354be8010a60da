// SPDX-License-Identifier: Apache-2.0
// Copies the result of an earlier job for a new job that would make the same result.
#pragma once

#include <string>

#include "host/foundation/sandbox/path_roots.h"

namespace multum {

/// Copies a finished result, which is a file or a folder, to another name, and syncs it. Follows no symbolic links in
/// the source or the target. Throws Error(kEnvironment), for example if the result contains a link or a device. Also
/// throws like PathRoots::open_folder_of().
void copy_result(const PathRoots& roots, const std::string& from, const std::string& to);

}  // namespace multum
