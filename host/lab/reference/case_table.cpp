// SPDX-License-Identifier: Apache-2.0
#include "host/lab/reference/case_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

nlohmann::json error_json(double error) {
  if (std::isfinite(error)) return error;
  return error_text(error);
}

double parsed_error(const nlohmann::json& json) {
  if (json.is_number()) return json.get<double>();
  return json.get<std::string>() == "inf" ? std::numeric_limits<double>::infinity()
                                          : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace

std::string case_table(const NumericalRun& run) {
  std::size_t width = 4;
  bool has_naive = false;  // whether a case has an error without its guard, or with a bug
  for (const NumericalVerdict& v : run.verdicts) {
    width = std::max(width, v.text.name.size());
    has_naive = has_naive || v.without_guard || v.mutated;
  }
  const auto row = [&](const std::string& name, const std::string& worst, const std::string& bound,
                       const std::string& naive, const std::string& mutated, const std::string& verdict) {
    return fmt::format("{:<{}}  {:>8}  {:>8}  {}{}\n", name, width, worst, bound,
                       has_naive ? fmt::format("{:>8}  {:>8}  ", naive, mutated) : std::string(), verdict);
  };
  std::string text = row("case", "worst", "bound", "without", "mutated", "verdict");
  for (const NumericalVerdict& v : run.verdicts)
    text +=
        row(v.text.name, error_text(v.worst), bound_text(v.text.bound), tried_text(v.without_guard),
            tried_text(v.mutated), v.holds() ? "ok" : fmt::format("BROKEN ({}, at {})", v.text.formula, v.worst_input));
  return text;
}

std::string case_json(const NumericalRun& run) {
  nlohmann::json cases = nlohmann::json::array();
  for (const NumericalVerdict& v : run.verdicts)
    cases.push_back({{"name", v.text.name},
                     {"formula", v.text.formula},
                     {"without_guard", v.text.without_guard},
                     {"guard", v.text.guard},
                     {"bound", v.text.bound},
                     {"unit", v.text.unit},
                     {"bound_reason", v.text.bound_reason},
                     {"worst", error_json(v.worst)},
                     {"worst_input", v.worst_input},
                     {"worst_without_guard", v.without_guard ? error_json(*v.without_guard) : nlohmann::json()},
                     {"worst_mutated", v.mutated ? error_json(*v.mutated) : nlohmann::json()},
                     {"holds", v.holds()}});
  const nlohmann::json json = {{"kind", run.kind},         {"device", run.device}, {"platform", run.platform},
                               {"driver", run.driver},     {"holds", run.holds()}, {"software", run.software},
                               {"cases", std::move(cases)}};
  return json.dump(2) + "\n";
}

NumericalRun parse_case_json(const std::string& text, const std::string& path) {
  try {
    const nlohmann::json json = nlohmann::json::parse(text);
    NumericalRun run{json.at("kind"),   json.at("device"),   json.at("platform"),
                     json.at("driver"), json.at("software"), {}};
    for (const nlohmann::json& c : json.at("cases")) {
      NumericalVerdict v{{c.at("name"), c.at("formula"), c.at("without_guard"), c.at("guard"), c.at("bound"),
                          c.at("unit"), c.at("bound_reason")},
                         parsed_error(c.at("worst")),
                         c.at("worst_input"),
                         {}};
      if (const nlohmann::json& naive = c.at("worst_without_guard"); !naive.is_null())
        v.without_guard = parsed_error(naive);
      if (const nlohmann::json& mutated = c.at("worst_mutated"); !mutated.is_null()) v.mutated = parsed_error(mutated);
      run.verdicts.push_back(std::move(v));
    }
    return run;
  } catch (const nlohmann::json::exception& error) {
    throw Error(ErrorCode::kInput,
                fmt::format("{}: is not the output of `multum selftest --report`: {}", path, error.what()));
  }
}

}  // namespace multum
