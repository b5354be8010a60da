// SPDX-License-Identifier: Apache-2.0
// TOML read strictly: every key is known, every value is of the type and in the range that is expected, and every
// refusal names the file, the line, the key, what was found and what was expected.
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

/// Parses the file. Throws Error(kInput) when it cannot be read, is beyond a limit or is no TOML; `expected`: "a job as
/// PAGE describes it". No more than the limit's bytes are read of it, of a pipe or a device either.
toml::table parse_toml(const std::string& path, const std::string& expected, const TomlLimits& limits = {});

struct NumberRange {
  double low = 0.0, high = 0.0;
  bool low_open = false, high_open = false;  // the end itself is not in the range
  std::string text;                          // "a number above 0"
};

inline const NumberRange kAboveZero = {0.0, std::numeric_limits<double>::infinity(), true, true, "a number above 0"};
inline const NumberRange kFromZero = {0.0, std::numeric_limits<double>::infinity(), false, true,
                                      "a number of at least 0"};

/// One table of a file; `file` and `table` outlive it.
class StrictTable {
 public:
  /// `name`: how its keys are called in messages, as "texture": "texture.wrap"; empty at the top. Keys that are not
  /// among `keys` are refused at once, with the known key that is nearest. `whole`: what the file is called.
  StrictTable(const std::string& file, const toml::table& table, std::string name, const std::vector<std::string>& keys,
              std::string whole = "the job");

  bool has(const std::string& key) const { return table_.contains(key); }
  /// Keys that are there, in alphabetical order: for tables whose keys are names.
  std::vector<std::string> keys() const;

  /// The key's value, or what `fallback` says where the key is missing; without a fallback the key must be there.
  std::string text(const std::string& key, const std::optional<std::string>& fallback = {}) const;
  /// The path that such a text names (host/foundation/base/path_text.h): TOML is UTF-8, names of files need not be.
  std::string path(const std::string& key, const std::optional<std::string>& fallback = {}) const;
  bool boolean(const std::string& key, bool fallback) const;
  int whole(const std::string& key, int low, int high, std::optional<int> fallback = {}) const;
  double number(const std::string& key, const NumberRange& range, double fallback) const;
  /// One of the choices' names; unset where the key is missing.
  template <typename List>
  auto choice(const std::string& key, const List& choices) const
      -> std::optional<typename List::value_type::second_type>;
  /// One number, or a list of at most `count_max`; none where the key is missing.
  std::vector<double> numbers(const std::string& key, const NumberRange& range, std::size_t count_max) const;
  std::vector<std::string> texts(const std::string& key, bool is_required) const;
  std::vector<int> integers(const std::string& key) const;
  /// Four rows of four finite numbers, for column vectors.
  glm::dmat4 matrix(const std::string& key) const;
  /// The table of this key; empty where there is none.
  const toml::table& table(const std::string& key) const;
  /// The tables of [[key]]: at least one, unless the key itself may be missing.
  std::vector<const toml::table*> tables(const std::string& key, bool is_required = true) const;

  /// Throws Error(kInput): "FILE:LINE: KEY is WHAT"; `key` may be empty, for the table itself.
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
