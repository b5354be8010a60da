// SPDX-License-Identifier: Apache-2.0
// What a table of figures says of the machine that made it.
#pragma once

#include <string>

namespace multum::bench {

std::string processor_name();
std::string system_name();  // "Debian GNU/Linux 12 (bookworm)"

}  // namespace multum::bench
