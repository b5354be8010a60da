// SPDX-License-Identifier: Apache-2.0
// An option that takes one of some names. CLI11's own transformers would take, and show, the enumerators' numbers too.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

namespace multum {

template <typename Value>
using Choices = std::vector<std::pair<std::string, Value>>;  // in the order that --help shows; must outlive the app

/// `value` may be an optional: it stays unset, and --help shows no default, until the option is given.
template <typename Target, typename Value>
void add_choice(CLI::App& app, const std::string& option, Target& value, const Choices<Value>& choices,
                const std::string& help) {
  std::vector<std::string> names;
  std::string default_name;
  for (const auto& [name, meaning] : choices) {
    names.push_back(name);
    if (value == meaning) default_name = name;
  }
  const auto choose = [&value, &choices](const std::string& text) {
    for (const auto& [name, meaning] : choices)
      if (name == text) value = meaning;
  };
  CLI::Option* const added = app.add_option_function<std::string>(option, choose, help)->check(CLI::IsMember(names));
  if (!default_name.empty()) added->default_str(default_name);
}

}  // namespace multum
