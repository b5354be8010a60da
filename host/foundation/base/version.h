// SPDX-License-Identifier: Apache-2.0
// Names this program and its version.
#pragma once

#include <string>

namespace multum {

/// "multum 0.1.0", as files name what made them.
const std::string& software_version();

}  // namespace multum
