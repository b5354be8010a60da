// SPDX-License-Identifier: Apache-2.0
// Reads numbers that files contain as text. strtod(), stod() and sscanf() expect a decimal comma if the program has set
// such a locale, and libmultum runs in programs of others. This function does not depend on the locale.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace multum {

/// Reads the number at the beginning of the text, after spaces and a plus sign. The decimal mark is a point. Stores the
/// text after the number in `rest`. Returns nullopt if there is no number, or if it is beyond the range of double.
/// Infinity and NaN count as numbers.
inline std::optional<double> leading_number(std::string_view text, std::string_view* rest = nullptr) {
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  if (text.starts_with('+') && !text.starts_with("+-")) text.remove_prefix(1);
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc()) return std::nullopt;
  if (rest != nullptr) *rest = text.substr(static_cast<std::size_t>(end - text.data()));
  return number;
}

}  // namespace multum
