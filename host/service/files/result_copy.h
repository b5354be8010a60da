// SPDX-License-Identifier: Apache-2.0
// Copies the result of an earlier job for one that would make the same.
#pragma once

#include <string>

namespace multum {

/// A finished result, file or folder, once more under another name, on disk when this returns. Throws
/// Error(kEnvironment).
void copy_result(const std::string& from, const std::string& to);

}  // namespace multum
