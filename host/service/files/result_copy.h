// SPDX-License-Identifier: Apache-2.0
// A job whose result another one has made already gets a copy of it.
#pragma once

#include <string>

namespace multum {

/// A finished result, file or folder, once more under another name, on disk when this returns. Throws
/// Error(kEnvironment).
void copy_result(const std::string& from, const std::string& to);

}  // namespace multum
