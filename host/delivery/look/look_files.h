// SPDX-License-Identifier: Apache-2.0
// Files of the page of `multum look`, as they are part of the program. Made by tools/embed_files.py.
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

/// The files of runtime_gl/web/look, by name.
const std::map<std::string, std::string_view>& look_page_files();

/// Modules of runtime_gl/web that the page has too, by name.
const std::map<std::string, std::string_view>& look_module_files();

/// Those of runtime_gl/shaders that the page draws with, by path.
const std::map<std::string, std::string_view>& look_shader_files();

}  // namespace multum
