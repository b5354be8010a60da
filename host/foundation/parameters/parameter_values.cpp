// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/parameter_values.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace multum {

void ParameterValues::set(const std::string& name, ParameterValue value) {
  const Parameter& parameter = table_->at(name);
  // A whole number is also a legal value for kNumber.
  if (const auto* integer = std::get_if<std::int64_t>(&value);
      integer != nullptr && parameter.kind == ParameterKind::kNumber)
    value = static_cast<double>(*integer);
  if (!is_legal(parameter, value))
    throw Error(ErrorCode::kUsage, fmt::format("{} is {}, expected {}", parameter.option(),
                                               value_text(parameter, value), expected_text(parameter)));
  values_[parameter.name] = std::move(value);
}

bool ParameterValues::is_given(const std::string& name) const {
  const auto found = values_.find(table_->at(name).name);
  if (found == values_.end()) return false;
  const auto* const flag = std::get_if<bool>(&found->second);
  return flag == nullptr || *flag;
}

const ParameterValue* ParameterValues::find(const std::string& name, ParameterKind kind) const {
  const Parameter& parameter = table_->at(name);
  const bool is_text = !parameter.is_numeric() && parameter.kind != ParameterKind::kFlag;
  MULTUM_CHECK(parameter.kind == kind || (is_text && kind == ParameterKind::kText));
  const auto found = values_.find(parameter.name);
  return found == values_.end() ? nullptr : &found->second;
}

bool ParameterValues::flag(const std::string& name) const {
  const ParameterValue* const value = find(name, ParameterKind::kFlag);
  return value != nullptr && std::get<bool>(*value);
}

std::optional<int> ParameterValues::integer(const std::string& name) const {
  const ParameterValue* const value = find(name, ParameterKind::kInteger);
  if (value == nullptr) return std::nullopt;
  return static_cast<int>(std::get<std::int64_t>(*value));
}

std::optional<std::int64_t> ParameterValues::bytes(const std::string& name) const {
  const ParameterValue* const value = find(name, ParameterKind::kBytes);
  if (value == nullptr) return std::nullopt;
  return std::get<std::int64_t>(*value);
}

std::optional<double> ParameterValues::number(const std::string& name) const {
  const ParameterValue* const value = find(name, ParameterKind::kNumber);
  if (value == nullptr) return std::nullopt;
  return std::get<double>(*value);
}

std::optional<std::string> ParameterValues::text(const std::string& name) const {
  const ParameterValue* const value = find(name, ParameterKind::kText);
  if (value == nullptr) return std::nullopt;
  return std::get<std::string>(*value);
}

std::string ParameterValues::options_text(const std::vector<std::string>& groups) const {
  std::string text;
  for (const Parameter& row : table_->rows()) {
    const auto found = values_.find(row.name);
    if (found == values_.end()) continue;
    if (!groups.empty() && std::find(groups.begin(), groups.end(), row.group) == groups.end()) continue;
    const auto* const flag = std::get_if<bool>(&found->second);
    if (flag != nullptr && !*flag) continue;
    text += (text.empty() ? "" : " ") + row.option();
    if (flag != nullptr) continue;
    const auto* const words = std::get_if<std::string>(&found->second);
    text += " " + (words != nullptr ? *words : value_text(found->second));
  }
  return text;
}

void check_exclusions(const ParameterValues& values) {
  for (const Parameter& row : values.table().rows())
    for (const std::string& other : row.excludes)
      if (values.is_given(row.name) && values.is_given(other))
        throw Error(ErrorCode::kUsage,
                    fmt::format("{} excludes {}, found both", row.option(), values.table().at(other).option()));
}

}  // namespace multum
