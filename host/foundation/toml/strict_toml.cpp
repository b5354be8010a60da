// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/toml/strict_toml.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/nearest_name.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/shown_text.h"

namespace multum {
namespace {

// Shortens the message. It quotes names and texts of the file, which can be megabytes long.
[[noreturn]] void refuse_at(const std::string& file, std::uint32_t line, std::string what) {
  constexpr std::size_t kBytesMax = 1000;
  if (what.size() > kBytesMax)
    what = what.substr(0, whole_characters(std::string_view(what).substr(0, kBytesMax))) + "...";
  throw Error(ErrorCode::kInput, line > 0 ? fmt::format("{}:{}: {}", file, line, what) : file + ": " + what);
}

std::uint32_t line_of(const toml::node& node) { return node.source().begin.line; }

std::string shown(const toml::node& node) {
  if (const auto* text = node.as_string()) return fmt::format("\"{}\"", text->get());
  if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
  if (const auto* number = node.as_floating_point()) return fmt::format("{}", number->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  if (const auto* array = node.as_array()) return fmt::format("an array of {}", array->size());
  return node.is_table() ? "a table" : "a date or time";
}

// Reads at most `byte_max` + 1 bytes.
std::string read_text(const std::string& path, const std::string& expected, std::size_t byte_max) {
  if (std::error_code ignored; std::filesystem::is_directory(path, ignored))
    throw Error(ErrorCode::kInput, path + ": is a folder, expected " + expected);
  RegularFileStream file(path, StandardInput::kAllowed);
  std::string text;
  constexpr std::size_t kBlockBytes = 1 << 16;
  while (file && text.size() <= byte_max) {
    const std::size_t begin = text.size(), wanted = std::min(kBlockBytes, byte_max + 1 - begin);
    text.resize(begin + wanted);
    file.read(text.data() + begin, static_cast<std::streamsize>(wanted));
    text.resize(begin + static_cast<std::size_t>(file.gcount()));
  }
  // The end of the file sets both failbit and eofbit.
  if (!file && !file.eof()) throw Error(ErrorCode::kInput, path + ": cannot be read, expected " + expected);
  return text;
}

[[noreturn]] void refuse_nul_at(const std::string& path, std::uint32_t line) {
  refuse_at(path, line, "holds the character NUL (\\u0000), which no string or key may contain");
}

// System functions end names at NUL, so two parts of a program would see two different names. TomlLimits limit the
// depth of the recursion.
void refuse_nul_in(const std::string& path, const toml::node& node) {
  if (const auto* text = node.as_string(); text != nullptr && text->get().find('\0') != std::string::npos)
    refuse_nul_at(path, line_of(node));
  if (const auto* array = node.as_array())
    for (const toml::node& child : *array) refuse_nul_in(path, child);
  if (const auto* table = node.as_table())
    for (const auto& [key, child] : *table) {
      if (key.str().find('\0') != std::string_view::npos) refuse_nul_at(path, key.source().begin.line);
      refuse_nul_in(path, child);
    }
}

std::optional<double> number_of(const toml::node& node) {
  if (const auto* number = node.as_integer()) return static_cast<double>(number->get());
  if (const auto* number = node.as_floating_point()) return number->get();
  return std::nullopt;
}

}  // namespace

toml::table parse_toml(const std::string& path, const std::string& expected, const TomlLimits& limits) {
  const std::string text = read_text(path, expected, limits.byte_max);
  check_toml_limits(path, text, limits);
  try {
    toml::table table = toml::parse(text);
    refuse_nul_in(path, table);
    return table;
  } catch (const toml::parse_error& error) {
    refuse_at(path, error.source().begin.line, fmt::format("invalid TOML: {}", error.description()));
  }
}

StrictTable::StrictTable(const std::string& file, const toml::table& table, std::string name,
                         const std::vector<std::string>& keys, std::string whole)
    : file_(file), table_(table), name_(std::move(name)), whole_(std::move(whole)) {
  for (const auto& [key, value] : table_) {
    const std::string text(key.str());
    if (keys.empty() || std::find(keys.begin(), keys.end(), text) != keys.end()) continue;
    const std::string nearest = nearest_name(text, keys);
    const std::string meant = nearest.empty() ? "" : fmt::format(" (did you mean '{}'?)", full_name(nearest));
    refuse_at(file_, key.source().begin.line, fmt::format("unknown key '{}' of {}{}", full_name(text), whole_, meant));
  }
}

std::vector<std::string> StrictTable::keys() const {
  std::vector<std::string> names;
  for (const auto& [key, value] : table_) names.emplace_back(key.str());
  return names;
}

void StrictTable::refuse(const std::string& key, const std::string& what) const {
  const toml::node* node = key.empty() ? nullptr : table_.get(key);
  refuse_at(file_, line_of(node != nullptr ? *node : table_),
            (key.empty() ? (name_.empty() ? whole_ : name_) : full_name(key)) + " " + what);
}

void StrictTable::refuse_value(const std::string& key, const toml::node& value, const std::string& expected) const {
  refuse_at(file_, line_of(value), fmt::format("{} is {}, expected {}", full_name(key), shown(value), expected));
}

const toml::node* StrictTable::find(const std::string& key, bool is_required) const {
  const toml::node* node = table_.get(key);
  if (node == nullptr && is_required) refuse("", fmt::format("has no {}, which is required", key));
  return node;
}

std::string StrictTable::text(const std::string& key, const std::optional<std::string>& fallback) const {
  const toml::node* node = find(key, !fallback);
  if (node == nullptr) return *fallback;
  if (!node->is_string()) refuse_value(key, *node, "a string in quotes");
  if (!fallback && node->as_string()->get().empty()) refuse_value(key, *node, "a string that is not empty");
  return node->as_string()->get();
}

std::string StrictTable::path(const std::string& key, const std::optional<std::string>& fallback) const {
  return path_of_text(text(key, fallback));
}

bool StrictTable::boolean(const std::string& key, bool fallback) const {
  const toml::node* node = find(key, false);
  if (node == nullptr) return fallback;
  if (!node->is_boolean()) refuse_value(key, *node, "true or false");
  return node->as_boolean()->get();
}

int StrictTable::whole(const std::string& key, int low, int high, std::optional<int> fallback) const {
  const toml::node* node = find(key, !fallback);
  if (node == nullptr) return *fallback;
  const auto* value = node->as_integer();
  if (value == nullptr || value->get() < low || value->get() > high)
    refuse_value(key, *node, fmt::format("an integer from {} to {}", low, high));
  return static_cast<int>(value->get());
}

double StrictTable::number(const std::string& key, const NumberRange& range, double fallback) const {
  const toml::node* node = find(key, false);
  return node == nullptr ? fallback : number_in(key, *node, range);
}

double StrictTable::number_in(const std::string& key, const toml::node& node, const NumberRange& range) const {
  const std::optional<double> value = number_of(node);
  const bool is_inside = value && std::isfinite(*value) &&
                         (range.low_open ? *value > range.low : *value >= range.low) &&
                         (range.high_open ? *value < range.high : *value <= range.high);
  if (!is_inside) refuse_value(key, node, range.text);
  return *value;
}

std::vector<double> StrictTable::numbers(const std::string& key, const NumberRange& range,
                                         std::size_t count_max) const {
  const toml::node* node = find(key, false);
  if (node == nullptr) return {};
  if (!node->is_array()) return {number_in(key, *node, range)};
  std::vector<double> result;
  for (const toml::node& item : *node->as_array())
    result.push_back(number_in(fmt::format("{}[{}]", key, result.size()), item, range));
  if (result.empty() || result.size() > count_max) refuse_value(key, *node, fmt::format("1 to {} numbers", count_max));
  return result;
}

std::vector<std::string> StrictTable::texts(const std::string& key, bool is_required) const {
  const toml::node* node = find(key, is_required);
  if (node == nullptr) return {};
  if (!node->is_array()) refuse_value(key, *node, "a list of strings in quotes");
  std::vector<std::string> result;
  for (const toml::node& item : *node->as_array()) {
    if (!item.is_string()) refuse_value(key + "[" + std::to_string(result.size()) + "]", item, "a string in quotes");
    result.push_back(item.as_string()->get());
  }
  return result;
}

std::vector<int> StrictTable::integers(const std::string& key) const {
  const toml::node* node = find(key, true);
  if (!node->is_array()) refuse_value(key, *node, "a list of integers");
  std::vector<int> result;
  for (const toml::node& item : *node->as_array()) {
    const auto* value = item.as_integer();
    if (value == nullptr || value->get() < 0 || value->get() > INT32_MAX)
      refuse_value(key + "[" + std::to_string(result.size()) + "]", item, "an integer of at least 0");
    result.push_back(static_cast<int>(value->get()));
  }
  return result;
}

glm::dmat4 StrictTable::matrix(const std::string& key) const {
  const toml::node* node = find(key, true);
  const std::string expected = "4 rows of 4 finite numbers";
  if (!node->is_array() || node->as_array()->size() != 4) refuse_value(key, *node, expected);
  glm::dmat4 m;
  for (int row = 0; row < 4; ++row) {
    const std::string row_name = fmt::format("{}[{}]", key, row);
    const toml::node& row_node = *node->as_array()->get(static_cast<std::size_t>(row));
    if (!row_node.is_array() || row_node.as_array()->size() != 4) refuse_value(row_name, row_node, expected);
    for (int column = 0; column < 4; ++column) {
      const toml::node& item = *row_node.as_array()->get(static_cast<std::size_t>(column));
      const std::optional<double> value = number_of(item);
      if (!value || !std::isfinite(*value)) refuse_value(fmt::format("{}[{}]", row_name, column), item, expected);
      m[column][row] = *value;
    }
  }
  return m;
}

const toml::table& StrictTable::table(const std::string& key) const {
  static const toml::table empty;
  const toml::node* node = find(key, false);
  if (node == nullptr) return empty;
  if (!node->is_table()) refuse_value(key, *node, "a table");
  return *node->as_table();
}

std::vector<const toml::table*> StrictTable::tables(const std::string& key, bool is_required) const {
  const toml::node* node = find(key, is_required);
  if (node == nullptr) return {};
  if (!node->is_array() || node->as_array()->empty()) refuse_value(key, *node, "tables, as [[" + key + "]]");
  std::vector<const toml::table*> result;
  for (const toml::node& item : *node->as_array()) {
    if (!item.is_table()) refuse_value(key, item, "tables, as [[" + key + "]]");
    result.push_back(item.as_table());
  }
  return result;
}

}  // namespace multum
