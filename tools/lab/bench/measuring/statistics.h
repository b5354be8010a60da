// SPDX-License-Identifier: Apache-2.0
// A quantity measured several times: its median and quartiles, as numbers, JSON and text.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace multum::bench {

struct Spread {
  double median;
  double low, high;  // first and third quartile
};

/// Quantiles lie on the straight line between the two values beside them (rank p (n - 1), counted from 0). `values`
/// must not be empty.
Spread spread_of(std::vector<double> values);

/// {"median": 1.0, "quartiles": [0.9, 1.2]} and back.
nlohmann::ordered_json spread_json(const Spread& spread);
Spread parse_spread(const nlohmann::ordered_json& json);

/// "1.00 (0.90 .. 1.20)", all with the decimals that rounded_text() gives the median, or "1.00" alone when that is what
/// the quartiles round to as well.
std::string spread_text(const Spread& spread);

/// `value` with three significant digits, or to the next whole number if that has more: "0.00123", "1.23", "1235".
std::string rounded_text(double value);

}  // namespace multum::bench
