// SPDX-License-Identifier: Apache-2.0
// The shading of lobes in other languages, as tools/shading_languages.py writes it when the project is built.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

/// By file name.
const std::map<std::string, std::string_view>& shading_files();

}  // namespace multum
