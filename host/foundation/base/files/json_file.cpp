// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/json_file.h"

#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

template <typename Json>
bool is_all_utf8(const Json& json) {
  if (json.is_string()) return is_utf8(json.template get_ref<const std::string&>());
  if (json.is_object())
    for (const auto& [key, value] : json.items())
      if (!is_utf8(key)) return false;
  if (json.is_structured())
    for (const Json& value : json)
      if (!is_all_utf8(value)) return false;
  return true;
}

std::string escaped_where_needed(const std::string& text) { return is_utf8(text) ? text : text_of_path(text); }

template <typename Json>
Json with_escapes(const Json& json) {
  if (json.is_string()) return escaped_where_needed(json.template get_ref<const std::string&>());
  if (!json.is_structured()) return json;
  Json made = json.is_object() ? Json::object() : Json::array();
  for (const auto& [key, value] : json.items())
    if (json.is_object()) made[escaped_where_needed(key)] = with_escapes(value);
    else made.push_back(with_escapes(value));
  return made;
}

template <typename Json>
std::string text_of(const Json& json, int indent, bool is_ascii) {
  return is_all_utf8(json) ? json.dump(indent, ' ', is_ascii) : with_escapes(json).dump(indent, ' ', is_ascii);
}

// Returns the value as text, shortened for a message.
std::string shown_value(const nlohmann::json& value) {
  constexpr std::size_t kShownMax = 40;
  const std::string text = json_text(value);
  return text.size() <= kShownMax ? text : text.substr(0, whole_characters(text.substr(0, kShownMax))) + "...";
}

}  // namespace

std::optional<std::string> json_of_file(const std::string& path, StandardInput input) {
  RegularFileStream file(path, input);
  if (!file) return std::nullopt;
  std::string text{std::istreambuf_iterator<char>(file), {}};
  if (file.bad()) return std::nullopt;
  refuse_nul(text, path);
  return text;
}

// In valid JSON, a backslash occurs only within strings, where it begins an escape.
bool holds_nul(std::string_view json) {
  if (json.find('\0') != std::string_view::npos) return true;
  for (std::size_t at = json.find('\\'); at != std::string_view::npos; at = json.find('\\', at + 2))
    if (json.substr(at + 1).starts_with("u0000")) return true;
  return false;
}

void refuse_nul(std::string_view json, const std::string& path) {
  if (holds_nul(json)) refuse_file(path, "its JSON holds the character NUL (\\u0000), which no string may contain");
}

std::int64_t json_integer_of(const nlohmann::json& value, const std::string& what, std::int64_t low,
                             std::int64_t high) {
  if (!value.is_number()) static_cast<void>(value.get<std::int64_t>());  // this throws
  const bool is_beyond = value.is_number_unsigned() && value.get<std::uint64_t>() > std::uint64_t{INT64_MAX};
  const bool is_legal =
      value.is_number_integer() && !is_beyond && value.get<std::int64_t>() >= low && value.get<std::int64_t>() <= high;
  if (is_legal) return value.get<std::int64_t>();
  throw Error(ErrorCode::kInput,
              fmt::format("{} is {}, expected an integer from {} to {}", what, shown_value(value), low, high));
}

std::int64_t json_integer(const nlohmann::json& object, const char* key, std::int64_t low, std::int64_t high) {
  return json_integer_of(object.at(key), key, low, high);
}

int json_int(const nlohmann::json& object, const char* key) {
  return static_cast<int>(json_integer(object, key, INT32_MIN, INT32_MAX));
}

std::vector<int> json_ints_of(const nlohmann::json& value, const std::string& what) {
  if (!value.is_array()) static_cast<void>(value.get<std::vector<int>>());  // this throws
  std::vector<int> numbers;
  for (const nlohmann::json& one : value)
    numbers.push_back(
        static_cast<int>(json_integer_of(one, fmt::format("{}[{}]", what, numbers.size()), INT32_MIN, INT32_MAX)));
  return numbers;
}

std::vector<int> json_ints(const nlohmann::json& object, const char* key) { return json_ints_of(object.at(key), key); }

std::string json_text(const nlohmann::json& json, int indent, bool is_ascii) { return text_of(json, indent, is_ascii); }
std::string json_text(const nlohmann::ordered_json& json, int indent, bool is_ascii) {
  return text_of(json, indent, is_ascii);
}

}  // namespace multum
