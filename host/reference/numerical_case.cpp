// SPDX-License-Identifier: Apache-2.0
#include "host/reference/numerical_case.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
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

std::string bound_text(double bound) { return error_text(bound <= kNothingWrong ? 0.0 : bound); }

}  // namespace multum
