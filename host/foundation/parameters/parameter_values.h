// SPDX-License-Identifier: Apache-2.0
// Holds the values that a command line, a file or a job gives to the parameters of one command.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "host/foundation/base/choices.h"
#include "host/foundation/base/error.h"
#include "host/foundation/parameters/parameter.h"

namespace multum {

/// Holds legal values for the parameters of a table. A parameter is unset if no value was given.
class ParameterValues {
 public:
  /// The table must outlive the values.
  explicit ParameterValues(const ParameterTable& table) : table_(&table) {}

  const ParameterTable& table() const { return *table_; }
  bool has(const std::string& name) const { return values_.contains(table_->at(name).name); }
  /// Returns whether the parameter has a value. A flag with the value false does not count.
  bool is_given(const std::string& name) const;

  /// Sets a value. Throws Error(kUsage) for an illegal value, such as "--lobes is 9, expected an integer from 1 to 8".
  void set(const std::string& name, ParameterValue value);
  void set(const std::string& name, bool value) { set(name, ParameterValue(value)); }
  void set(const std::string& name, int value) { set(name, ParameterValue(std::int64_t{value})); }
  void set(const std::string& name, const char* value) { set(name, ParameterValue(std::string(value))); }
  void erase(const std::string& name) { values_.erase(table_->at(name).name); }

  /// Return a value of a known type. The parameter must be of the corresponding kind. Return nullopt for an unset
  /// parameter.
  bool flag(const std::string& name) const;  // false if unset
  std::optional<int> integer(const std::string& name) const;
  std::optional<std::int64_t> bytes(const std::string& name) const;
  std::optional<double> number(const std::string& name) const;
  std::optional<std::string> text(const std::string& name) const;
  template <typename Value>
  std::optional<Value> choice(const std::string& name, const Choices<Value>& choices) const;

  /// Returns the values as options, in the order of the table: "--ndf vmf --lobes 3". Uses only the given `groups`, or
  /// all groups if `groups` is empty.
  std::string options_text(const std::vector<std::string>& groups = {}) const;

 private:
  const ParameterValue* find(const std::string& name, ParameterKind kind) const;
  const ParameterTable* table_;
  std::map<std::string, ParameterValue> values_;
};

/// Throws Error(kUsage) if two given parameters exclude each other, as in "--gloss excludes --roughness, found both".
void check_exclusions(const ParameterValues& values);

template <typename Value>
std::optional<Value> ParameterValues::choice(const std::string& name, const Choices<Value>& choices) const {
  const std::optional<std::string> chosen = text(name);
  if (!chosen) return std::nullopt;
  const std::optional<Value> value = find_choice(choices, *chosen);
  MULTUM_CHECK(value.has_value());
  return value;
}

}  // namespace multum
