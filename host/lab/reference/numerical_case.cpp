// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/numerical_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <regex>
#include <sstream>

namespace multum {

void WorstError::add(double error, const std::string& input) {
  ++count_;
  if (std::isnan(value_)) return;
  if (!std::isnan(error) && error <= value_ && !input_.empty()) return;
  value_ = error;
  input_ = input;
}

void WorstError::add(double found, double expected, double unit, const std::string& input) {
  add(found == expected ? 0.0 : std::abs(found - expected) / unit, input);
}

bool NumericalRun::holds() const {
  return std::all_of(verdicts.begin(), verdicts.end(), [](const NumericalVerdict& v) { return v.holds(); });
}

double least_error(double a, double b) {
  if (std::isnan(a)) return b;
  return std::isnan(b) ? a : std::min(a, b);
}

std::string fault_of_guards(const std::vector<SourceEdit>& without) {
  // Matches a number such as 4, but not the 4 in float4.
  const std::regex number("(^|[^A-Za-z0-9_.])(0x[0-9a-fA-F]+|[0-9]+\\.?[0-9]*(e[-+]?[0-9]+)?f?)");
  for (const SourceEdit& edit : without) {
    const auto blank = [&](const std::string& text) {
      std::string blanked = std::regex_replace(text, number, "$1#");
      std::erase_if(blanked, [](char c) { return c == '-' || c == ' '; });
      return blanked;
    };
    if (blank(edit.text) == blank(edit.replacement))
      return fmt::format("the edit from '{}' to '{}' changes only numbers, so it does not remove a guard", edit.text,
                         edit.replacement);
    for (const SourceEdit& other : without)
      if (&other != &edit && other.file == edit.file && other.text == edit.text)
        return fmt::format("'{}' is removed twice", edit.text);
  }
  return "";
}

std::vector<std::string> split_names(const std::string& formula) {
  std::vector<std::string> names;
  std::istringstream in(formula);
  for (std::string name; std::getline(in >> std::ws, name, ',');) names.push_back(name.substr(0, name.find(" (")));
  return names;
}

std::string error_text(double error) {
  if (std::isnan(error)) return "NaN";
  if (std::isinf(error)) return "inf";
  return error == 0.0 ? "0" : fmt::format("{:.1e}", error);
}

std::string tried_text(const std::optional<double>& error) { return error ? error_text(*error) : "-"; }

std::string bound_text(double bound) { return error_text(bound <= kNothingWrong ? 0.0 : bound); }

}  // namespace multum
