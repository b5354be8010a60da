// SPDX-License-Identifier: Apache-2.0
// Names the values of a setting, the same on a command line and in a file.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace multum {

template <typename Value>
using Choices = std::vector<std::pair<std::string, Value>>;  // in the order in which they are shown

template <typename Value>
std::optional<Value> find_choice(const Choices<Value>& choices, const std::string& name) {
  for (const auto& [own_name, value] : choices)
    if (own_name == name) return value;
  return std::nullopt;
}

template <typename Value>
std::vector<std::string> choice_names(const Choices<Value>& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.push_back(name);
  return names;
}

/// The name of one of them.
template <typename Value>
const char* choice_name(const Choices<Value>& choices, Value value) {
  for (const auto& [name, own_value] : choices)
    if (own_value == value) return name.c_str();
  return "?";
}

}  // namespace multum
