// SPDX-License-Identifier: Apache-2.0
#include "tools/lab/bench/measuring/statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/foundation/base/error.h"

namespace multum::bench {
namespace {

double quantile(const std::vector<double>& sorted, double p) {
  const double rank = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(rank);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (rank - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

// Returns the number of decimals for three significant digits of `value`.
int decimals_of(double value) {
  if (!(std::abs(value) > 0.0)) return 2;
  return std::clamp(2 - static_cast<int>(std::floor(std::log10(std::abs(value)))), 0, 9);
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  MULTUM_CHECK(!values.empty());
  std::sort(values.begin(), values.end());
  return {quantile(values, 0.5), quantile(values, 0.25), quantile(values, 0.75)};
}

nlohmann::ordered_json spread_json(const Spread& spread) {
  return {{"median", spread.median}, {"quartiles", {spread.low, spread.high}}};
}

Spread parse_spread(const nlohmann::ordered_json& json) {
  return {json.at("median").get<double>(), json.at("quartiles").at(0).get<double>(),
          json.at("quartiles").at(1).get<double>()};
}

std::string spread_text(const Spread& spread) {
  const int decimals = decimals_of(spread.median);
  const auto text = [&](double value) { return fmt::format("{:.{}f}", value, decimals); };
  const std::string median = text(spread.median), low = text(spread.low), high = text(spread.high);
  return low == median && high == median ? median : median + " (" + low + " .. " + high + ")";
}

std::string rounded_text(double value) { return fmt::format("{:.{}f}", value, decimals_of(value)); }

}  // namespace multum::bench
