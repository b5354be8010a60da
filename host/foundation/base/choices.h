// SPDX-License-Identifier: Apache-2.0
// Gives names to the values of a setting. Command lines and files use the same names.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace multum {

/// Pairs of names and values, in the order in which help texts show them. Tables use these lists when a program starts,
/// so a list must not need initialization at run time. It must be a constant at namespace scope.
template <typename Value>
using Choices = std::initializer_list<std::pair<const char*, Value>>;

/// Returns the value of a name in Choices, or in another list of pairs of names and values. Returns nullopt for an
/// unknown name.
template <typename List>
auto find_choice(const List& choices, const std::string& name)
    -> std::optional<typename List::value_type::second_type> {
  for (const auto& [own_name, value] : choices)
    if (own_name == name) return value;
  return std::nullopt;
}

/// Returns the names in Choices or in another list of pairs.
template <typename List>
std::vector<std::string> choice_names(const List& choices) {
  std::vector<std::string> names;
  for (const auto& [name, value] : choices) names.emplace_back(name);
  return names;
}

/// Returns the name of one value.
template <typename Value>
const char* choice_name(const Choices<Value>& choices, Value value) {
  for (const auto& [name, own_value] : choices)
    if (own_value == value) return name;
  return "?";
}

}  // namespace multum
