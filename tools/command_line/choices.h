// SPDX-License-Identifier: Apache-2.0
// Adds options that accept one of several names. The transformers of CLI11 would also accept and show the numeric
// values of enumerators.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "host/foundation/base/choices.h"

namespace multum {

/// `value` may be a std::optional. In this case it stays unset until the option is given, and --help shows no default.
/// `choices` must outlive the app.
template <typename Target, typename Value>
CLI::Option* add_choice(CLI::App& app, const std::string& option, Target& value, const Choices<Value>& choices,
                        const std::string& help) {
  std::string default_name;
  for (const auto& [name, meaning] : choices)
    if (value == meaning) default_name = name;
  const auto choose = [&value, &choices](const std::string& text) { value = *find_choice(choices, text); };
  CLI::Option* const added =
      app.add_option_function<std::string>(option, choose, help)->check(CLI::IsMember(choice_names(choices)));
  if (!default_name.empty()) added->default_str(default_name);
  return added;
}

}  // namespace multum
