// SPDX-License-Identifier: Apache-2.0
// Names this program and its version.
#pragma once

#include <string>

namespace multum {

/// "multum 0.1.0", the name of this program in files that it writes.
const std::string& software_version();

}  // namespace multum
