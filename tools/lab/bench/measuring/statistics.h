// SPDX-License-Identifier: Apache-2.0
// Computes the median and the quartiles of repeated measurements, and formats them as numbers, JSON and text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multum::bench {

struct Spread {
  double median;
  double low, high;  // first and third quartile
};

/// Interpolates quantiles linearly between neighbouring values (rank p (n - 1), counted from 0). `values` must not be
/// empty.
Spread spread_of(std::vector<double> values);

/// Converts to JSON: {"median": 1.0, "quartiles": [0.9, 1.2]}.
nlohmann::ordered_json spread_json(const Spread& spread);
Spread parse_spread(const nlohmann::ordered_json& json);

/// Writes text such as "1.00 (0.90 .. 1.20)", with the number of decimals that rounded_text() uses for the median. If
/// the quartiles round to the same number, writes only "1.00".
std::string spread_text(const Spread& spread);

/// Writes `value` with three significant digits, or as a whole number if it has more digits: "0.00123", "1.23", "1235".
std::string rounded_text(double value);

}  // namespace multum::bench
