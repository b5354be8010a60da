// SPDX-License-Identifier: Apache-2.0
// JSON from and for other programs: texts that hold NUL are refused, integers are those that fit, and names of files
// that are not UTF-8 are written as host/foundation/base/path_text has them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "host/foundation/base/files/regular_file.h"

namespace multum {

/// All of a file of JSON; nothing where it cannot be read. Throws Error(kInput): not a regular file, and what
/// refuse_nul() refuses.
std::optional<std::string> json_of_file(const std::string& path, StandardInput input = StandardInput::kRefused);

/// Throws Error(kInput), naming `path`, where a text or a key holds NUL (\u0000): functions that take names end there,
/// so that two parts of a program would see two names. `json` need not be valid.
void refuse_nul(std::string_view json, const std::string& path);
bool holds_nul(std::string_view json);

/// The integer under `key`. Throws Error(kInput) for other numbers: "width is 320.5, expected an integer from 1 to
/// 65536"; and nlohmann::json::exception for what is none, or where there is none.
std::int64_t json_integer(const nlohmann::json& object, const char* key, std::int64_t low, std::int64_t high);
/// The same of a value; `what` names it.
std::int64_t json_integer_of(const nlohmann::json& value, const std::string& what, std::int64_t low, std::int64_t high);

/// The same within the range of int.
int json_int(const nlohmann::json& object, const char* key);
std::vector<int> json_ints(const nlohmann::json& object, const char* key);
std::vector<int> json_ints_of(const nlohmann::json& value, const std::string& what);

/// dump(), with text_of_path() of each text and key that is not UTF-8. Paths that are UTF-8 go in by text_of_path()
/// too: a name of U+EF80 to U+EFFF would read as another one's.
/// `is_ascii`: with escapes for all that is not ASCII.
std::string json_text(const nlohmann::json& json, int indent = -1, bool is_ascii = false);
std::string json_text(const nlohmann::ordered_json& json, int indent = -1, bool is_ascii = false);

}  // namespace multum
