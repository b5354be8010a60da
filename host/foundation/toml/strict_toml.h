// SPDX-License-Identifier: Apache-2.0
// Reads TOML strictly: every key must be known, and every value must have the expected type and range. Every error
// names the file, the line, the key, the value found and the value expected.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <toml++/toml.h>
#include <glm/mat4x4.hpp>

#include "host/foundation/base/choices.h"
#include "host/foundation/toml/toml_limits.h"

namespace multum {

/// Parses the file. Throws Error(kInput) if it cannot be read, exceeds a limit or is not TOML. For example, `expected`
/// is "a job as PAGE describes it". Never reads more bytes than the limit, even from a pipe or a device.
toml::table parse_toml(const std::string& path, const std::string& expected, const TomlLimits& limits = {});

struct NumberRange {
  double low = 0.0, high = 0.0;
  bool low_open = false, high_open = false;  // true if the limit itself is outside the range
  std::string text;                          // description, such as "a number above 0"
};

inline const NumberRange kAboveZero = {0.0, std::numeric_limits<double>::infinity(), true, true, "a number above 0"};
inline const NumberRange kFromZero = {0.0, std::numeric_limits<double>::infinity(), false, true,
                                      "a number of at least 0"};

/// One table of a file. `file` and `table` must outlive it.
class StrictTable {
 public:
  /// In messages, `name` precedes the keys, so for "texture" they say "texture.wrap". `name` is empty for the top
  /// table. Keys that are not in `keys` are rejected at once, and the message names the most similar known key. `whole`
  /// names the contents of the file.
  StrictTable(const std::string& file, const toml::table& table, std::string name, const std::vector<std::string>& keys,
              std::string whole = "the job");

  bool has(const std::string& key) const { return table_.contains(key); }
  /// Returns the existing keys in alphabetical order, for tables whose keys are names.
  std::vector<std::string> keys() const;

  /// Returns the key's value, or `fallback` if the key is missing. Without a fallback, the key is required.
  std::string text(const std::string& key, const std::optional<std::string>& fallback = {}) const;
  /// Returns the path that the text encodes (host/foundation/base/path_text.h). TOML is UTF-8, but file names may not
  /// be.
  std::string path(const std::string& key, const std::optional<std::string>& fallback = {}) const;
  bool boolean(const std::string& key, bool fallback) const;
  int whole(const std::string& key, int low, int high, std::optional<int> fallback = {}) const;
  double number(const std::string& key, const NumberRange& range, double fallback) const;
  /// Returns the choice with this name; nullopt if the key is missing.
  template <typename List>
  auto choice(const std::string& key, const List& choices) const
      -> std::optional<typename List::value_type::second_type>;
  /// Returns one number, or a list of at most `count_max` numbers. Returns an empty list if the key is missing.
  std::vector<double> numbers(const std::string& key, const NumberRange& range, std::size_t count_max) const;
  std::vector<std::string> texts(const std::string& key, bool is_required) const;
  std::vector<int> integers(const std::string& key) const;
  /// Reads four rows of four finite numbers, which form a matrix for column vectors.
  glm::dmat4 matrix(const std::string& key) const;
  /// Returns the table of this key, or an empty table if the key is missing.
  const toml::table& table(const std::string& key) const;
  /// Returns the tables of [[key]]. At least one is required, unless the key may be missing.
  std::vector<const toml::table*> tables(const std::string& key, bool is_required = true) const;

  /// Throws Error(kInput) with the message "FILE:LINE: KEY is WHAT". For the table itself, `key` is empty.
  [[noreturn]] void refuse(const std::string& key, const std::string& what) const;

 private:
  [[noreturn]] void refuse_value(const std::string& key, const toml::node& value, const std::string& expected) const;
  double number_in(const std::string& key, const toml::node& node, const NumberRange& range) const;
  std::string full_name(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }
  const toml::node* find(const std::string& key, bool is_required) const;

  const std::string& file_;
  const toml::table& table_;
  std::string name_;
  std::string whole_;
};

template <typename List>
auto StrictTable::choice(const std::string& key, const List& choices) const
    -> std::optional<typename List::value_type::second_type> {
  if (!has(key)) return std::nullopt;
  const std::string name = text(key, "");
  const auto value = find_choice(choices, name);
  if (!value) refuse(key, fmt::format("is \"{}\", expected one of {}", name, fmt::join(choice_names(choices), ", ")));
  return value;
}

}  // namespace multum
