// SPDX-License-Identifier: Apache-2.0
// Reads and writes JSON for exchange with other programs. Rejects strings that hold NUL, and checks the ranges of
// integers. File names that are not UTF-8 are written as described in host/foundation/base/path_text.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "host/foundation/base/files/regular_file.h"

namespace multum {

/// Returns the contents of a whole JSON file, or nullopt if the file cannot be read. Throws Error(kInput) if the path
/// is not a regular file, or if the file holds NUL (refuse_nul()).
std::optional<std::string> json_of_file(const std::string& path, StandardInput input = StandardInput::kRefused);

/// Throws Error(kInput), which names `path`, if a string or a key holds NUL (\u0000). System functions end names at
/// NUL, so two parts of a program would see two different names. `json` does not have to be valid.
void refuse_nul(std::string_view json, const std::string& path);
bool holds_nul(std::string_view json);

/// Returns the integer under `key`. Throws Error(kInput) for other numbers: "width is 320.5, expected an integer from 1
/// to 65536". Throws nlohmann::json::exception if the value is not a number or is missing.
std::int64_t json_integer(const nlohmann::json& object, const char* key, std::int64_t low, std::int64_t high);
/// Like json_integer(), but checks a value that the caller has already found. Messages call this value `what`.
std::int64_t json_integer_of(const nlohmann::json& value, const std::string& what, std::int64_t low, std::int64_t high);

/// Like json_integer() and json_integer_of(), but return values in the range of int.
int json_int(const nlohmann::json& object, const char* key);
std::vector<int> json_ints(const nlohmann::json& object, const char* key);
std::vector<int> json_ints_of(const nlohmann::json& value, const std::string& what);

/// Like dump(), but replaces each text and key that is not UTF-8 by its text_of_path(). Callers must convert every
/// path, even a UTF-8 path, with text_of_path(). Otherwise a name that contains characters from U+EF80 to U+EFFF would
/// be read back as a different name. If `is_ascii`, escapes all characters that are not ASCII.
std::string json_text(const nlohmann::json& json, int indent = -1, bool is_ascii = false);
std::string json_text(const nlohmann::ordered_json& json, int indent = -1, bool is_ascii = false);

}  // namespace multum
