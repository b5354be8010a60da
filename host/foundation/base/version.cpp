// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/version.h"

namespace multum {

const std::string& software_version() {
  static const std::string name = std::string("multum ") + MULTUM_VERSION;
  return name;
}

}  // namespace multum
