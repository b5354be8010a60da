// SPDX-License-Identifier: Apache-2.0
// Copies the result of an earlier job for one that would make the same.
#pragma once

#include <string>

#include "host/foundation/sandbox/path_roots.h"

namespace multum {

/// A finished result, file or folder, once more under another name, on disk when this returns. Follows no link on
/// either side. Throws Error(kEnvironment) for a link or a device in it too, and as PathRoots::open_folder_of() does.
void copy_result(const PathRoots& roots, const std::string& from, const std::string& to);

}  // namespace multum
