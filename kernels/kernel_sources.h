// SPDX-License-Identifier: Apache-2.0
// The OpenCL sources that are compiled into the program: name of the .cl file -> its source, with its
// #includes in place.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

const std::map<std::string, std::string_view>& kernel_sources();

}  // namespace multum
