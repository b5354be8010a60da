// SPDX-License-Identifier: Apache-2.0
// Real maps and meshes, which tests want and can do without.
#pragma once

#include <cstdlib>
#include <string>

namespace multum::testing {

/// Their folder; empty: there is none here.
inline std::string shared_data() {
  const char* folder = std::getenv("MULTUM_SHARED_DATA");
  return folder != nullptr ? folder : "";
}

}  // namespace multum::testing
