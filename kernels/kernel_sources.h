// SPDX-License-Identifier: Apache-2.0
// Returns the OpenCL sources that are compiled into the program. The keys of the map are the names of .cl files, and
// the values are their sources with #includes expanded.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

const std::map<std::string, std::string_view>& kernel_sources();

}  // namespace multum
