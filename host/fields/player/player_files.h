// SPDX-License-Identifier: Apache-2.0
// The player of packed fields, as it is part of the program: the page of runtime_gl/web, and the decoder as WebAssembly
// where the build could compile it (tools/wasm_decoder).
#pragma once

#include <map>
#include <string>
#include <string_view>

namespace multum {

/// The files of runtime_gl/web, by name. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& player_web_files();

/// packed_field.mjs, and packed_field.wasm unless the build had no compiler for it. Made by tools/embed_files.py.
const std::map<std::string, std::string_view>& player_module_files();

}  // namespace multum
