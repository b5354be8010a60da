// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/parameters/parameter.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/brdf_families/brdf_forms.h"

namespace multum {
namespace {

template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string size_text(std::int64_t bytes) {
  return bytes % (1 << 20) == 0 ? fmt::format("{} MiB", bytes >> 20) : fmt::format("{} bytes", bytes);
}

std::string number_text(const Parameter& parameter) {
  if (parameter.kind == ParameterKind::kBytes)
    return "a size of at least " + size_text(static_cast<std::int64_t>(parameter.low));
  const bool is_number = parameter.kind == ParameterKind::kNumber;
  const std::string what = is_number ? "a number" : "an integer";
  const auto bound = [&](double value) {
    return is_number ? fmt::format("{:g}", value) : fmt::format("{}", static_cast<std::int64_t>(value));
  };
  std::string text;
  if (!parameter.has_low() && !parameter.has_high()) text = what;
  else if (!parameter.has_high())
    text = fmt::format("{} {} {}", what, parameter.low_excluded ? "above" : "of at least", bound(parameter.low));
  else if (parameter.low_excluded)
    text = fmt::format("{} above {}, at most {}", what, bound(parameter.low), bound(parameter.high));
  else text = fmt::format("{} from {} to {}", what, bound(parameter.low), bound(parameter.high));
  return text + (parameter.zero_excluded ? " other than 0" : "");
}

bool is_in_range(const Parameter& parameter, double value) {
  return std::isfinite(value) && value <= parameter.high &&
         (parameter.low_excluded ? value > parameter.low : value >= parameter.low) &&
         !(parameter.zero_excluded && static_cast<float>(value) == 0.0f);
}

}  // namespace

std::optional<std::int64_t> parse_size_text(const std::string& text) {
  const std::size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
  std::string unit = text.substr(digits);
  for (char& c : unit) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
  if (unit.ends_with("IB")) unit.resize(unit.size() - 2);
  else if (unit.ends_with("B")) unit.resize(unit.size() - 1);
  constexpr std::pair<const char*, int> kUnits[] = {{"", 0}, {"K", 10}, {"M", 20}, {"G", 30}, {"T", 40}};
  const auto found =
      std::find_if(std::begin(kUnits), std::end(kUnits), [&](const auto& one) { return unit == one.first; });
  const std::optional<std::int64_t> number = parse_number<std::int64_t>(std::string_view(text).substr(0, digits));
  if (found == std::end(kUnits) || !number) return std::nullopt;
  if (*number > std::numeric_limits<std::int64_t>::max() >> found->second) return std::nullopt;
  return *number << found->second;
}

std::string option_of(const std::string& name) {
  std::string text = "--" + name;
  std::replace(text.begin(), text.end(), '_', '-');
  return text;
}

std::string Parameter::option() const { return option_of(name); }

std::string expected_text(const Parameter& parameter) {
  switch (parameter.kind) {
    case ParameterKind::kFlag: return "true or false";
    case ParameterKind::kInteger:
    case ParameterKind::kNumber:
    case ParameterKind::kBytes: return number_text(parameter);
    case ParameterKind::kChoice:
      return "one of " +
             (parameter.unit.empty() ? fmt::format("{}", fmt::join(parameter.choices, ", ")) : parameter.unit);
    case ParameterKind::kText: return "a text";
    case ParameterKind::kBrdf: return brdf_forms("or");
    case ParameterKind::kFile: return "a file's path";
  }
  return "";
}

std::string value_text(const Parameter& parameter, const ParameterValue& value) {
  const auto* const bytes = std::get_if<std::int64_t>(&value);
  return bytes != nullptr && parameter.kind == ParameterKind::kBytes ? size_text(*bytes) : value_text(value);
}

std::string value_text(const ParameterValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *integer);
  if (const auto* number = std::get_if<double>(&value)) return fmt::format("{}", *number);
  return "\"" + std::get<std::string>(value) + "\"";
}

bool is_legal(const Parameter& parameter, const ParameterValue& value) {
  switch (parameter.kind) {
    case ParameterKind::kFlag: return std::holds_alternative<bool>(value);
    case ParameterKind::kInteger:
    case ParameterKind::kBytes: {
      const auto* integer = std::get_if<std::int64_t>(&value);
      return integer != nullptr && is_in_range(parameter, static_cast<double>(*integer));
    }
    case ParameterKind::kNumber: {
      const auto* number = std::get_if<double>(&value);
      return number != nullptr && is_in_range(parameter, *number);
    }
    case ParameterKind::kChoice: {
      const auto* text = std::get_if<std::string>(&value);
      return text != nullptr &&
             std::find(parameter.choices.begin(), parameter.choices.end(), *text) != parameter.choices.end();
    }
    case ParameterKind::kText:
    case ParameterKind::kBrdf:
    case ParameterKind::kFile: return std::holds_alternative<std::string>(value);
  }
  return false;
}

std::optional<ParameterValue> parse_value(const Parameter& parameter, const std::string& text) {
  switch (parameter.kind) {
    case ParameterKind::kFlag:
      if (text == "true" || text == "false") return text == "true";
      return std::nullopt;
    case ParameterKind::kInteger: return parse_number<std::int64_t>(text);
    case ParameterKind::kNumber: return parse_number<double>(text);
    case ParameterKind::kBytes: return parse_size_text(text);
    default: return text;
  }
}

ParameterTable::ParameterTable(std::string command, std::vector<Parameter> rows)
    : command_(std::move(command)), rows_(std::move(rows)) {}

const Parameter* ParameterTable::find(const std::string& name) const {
  const auto found = std::find_if(rows_.begin(), rows_.end(), [&](const Parameter& one) { return one.name == name; });
  return found == rows_.end() ? nullptr : &*found;
}

const Parameter& ParameterTable::at(const std::string& name) const {
  const Parameter* const found = find(name);
  MULTUM_CHECK(found != nullptr);
  return *found;
}

std::vector<std::string> ParameterTable::names(unsigned surface) const {
  std::vector<std::string> names;
  for (const Parameter& row : rows_)
    if (row.is_on(surface)) names.push_back(row.name);
  return names;
}

}  // namespace multum
