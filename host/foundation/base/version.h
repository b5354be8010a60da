// SPDX-License-Identifier: Apache-2.0
// Names this program and its version.
#pragma once

#include <string>

namespace multum {

/// The name of this program in the files that it writes, "multum 0.1.0".
const std::string& software_version();

}  // namespace multum
