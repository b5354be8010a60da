// SPDX-License-Identifier: Apache-2.0
// Scripts of this folder that other programs run, as parts of this one.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

/// By name. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& uastc_scripts();

}  // namespace multum
