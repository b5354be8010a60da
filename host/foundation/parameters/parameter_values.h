// SPDX-License-Identifier: Apache-2.0
// Holds what a command line, a file or a job says of the parameters of one command.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "host/foundation/base/choices.h"
#include "host/foundation/base/error.h"
#include "host/foundation/parameters/parameter.h"

namespace multum {

/// Values of a table's parameters, each legal; those that nobody gave are unset.
class ParameterValues {
 public:
  /// The table must outlive the values.
  explicit ParameterValues(const ParameterTable& table) : table_(&table) {}

  const ParameterTable& table() const { return *table_; }
  bool has(const std::string& name) const { return values_.contains(table_->at(name).name); }
  /// Is there a value, and not the false of a flag?
  bool is_given(const std::string& name) const;

  /// Throws Error(kUsage) for a value that is not legal: "--lobes is 9, expected an integer from 1 to 8".
  void set(const std::string& name, ParameterValue value);
  void set(const std::string& name, bool value) { set(name, ParameterValue(value)); }
  void set(const std::string& name, int value) { set(name, ParameterValue(std::int64_t{value})); }
  void set(const std::string& name, const char* value) { set(name, ParameterValue(std::string(value))); }
  void erase(const std::string& name) { values_.erase(table_->at(name).name); }

  /// Typed access; the parameter must be of that kind. Unset where nobody gave it.
  bool flag(const std::string& name) const;  // false where nobody gave it
  std::optional<int> integer(const std::string& name) const;
  std::optional<std::int64_t> bytes(const std::string& name) const;
  std::optional<double> number(const std::string& name) const;
  std::optional<std::string> text(const std::string& name) const;
  template <typename Value>
  std::optional<Value> choice(const std::string& name, const Choices<Value>& choices) const;

  /// As a command line has them, in the table's order: "--ndf vmf --lobes 3". `groups`: of these groups alone; empty:
  /// of all.
  std::string options_text(const std::vector<std::string>& groups = {}) const;

 private:
  const ParameterValue* find(const std::string& name, ParameterKind kind) const;
  const ParameterTable* table_;
  std::map<std::string, ParameterValue> values_;
};

/// Throws Error(kUsage): two that exclude one another are both given, as "--gloss excludes --roughness".
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
