// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/accuracy/accuracy_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

namespace multum {
namespace {

constexpr int kLevelMax = 63;  // no file has this many levels, because sides fit into 32 bits

// Rounds a value as the file does, before it is rounded again for the table. A bake and its file then give the same
// text.
double rounded(double error) { return std::round(error * 1e6) / 1e6; }

// Returns the half width in millionths, rounded up so that no stated interval is too narrow. The rounding error of the
// product is subtracted first.
double millionths_up(double half_width) { return std::max(0.0, std::ceil(half_width * 1e6 - 1e-6)); }
double hundredths_of_percent_up(double half_width) { return std::ceil(millionths_up(half_width) / 100.0); }

const AccuracyRow* find_row(const std::vector<AccuracyRow>& rows, int level, AccuracyPoint point,
                            const AccuracyBrdf& brdf) {
  for (const AccuracyRow& row : rows)
    if (row.level == level && row.point == point && row.brdf == brdf) return &row;
  return nullptr;
}

// Formats "1.23", or "1.23 +- 0.05" if texels were sampled.
std::string percent_text(const AccuracyRow* row) {
  if (row == nullptr) return "-";
  std::string text = fmt::format("{:.2f}", 100.0 * rounded(row->error));
  if (row->confidence > 0.0) text += fmt::format(" +- {:.2f}", hundredths_of_percent_up(row->confidence) / 100.0);
  return text;
}

const AccuracyRow* worse(const AccuracyRow* a, const AccuracyRow* b) {
  if (a == nullptr || b == nullptr) return a == nullptr ? b : a;
  return a->error < b->error ? b : a;
}

// States which texels of a level were measured.
std::string texels_text(double confidence) {
  if (confidence == kIntervalUnstated) return "unstated";
  return confidence > 0.0 ? "sampled" : "all";
}

// Returns the part of a table's heading that describes how its BRDFs were shaded, such as " of lean with colours".
std::string group_text(const AccuracyBrdf& brdf) {
  return (brdf.shading.empty() ? "" : " of " + brdf.shading) + (brdf.has_colours ? " with colours" : "");
}

bool is_shaded_alike(const AccuracyBrdf& a, const AccuracyBrdf& b) {
  return a.shading == b.shading && a.has_colours == b.has_colours;
}

// `brdfs` has at least one entry. All entries have the same shading method.
std::string table(const std::vector<AccuracyRow>& rows, const std::vector<AccuracyBrdf>& brdfs) {
  std::map<int, double> confidences;  // [level]: confidence of all rows of the level
  bool has_intervals = false;
  for (const AccuracyRow& row : rows) {
    confidences[row.level] = row.confidence;
    has_intervals = has_intervals || row.confidence > 0.0;
  }
  std::string text = fmt::format(
      "measured error{}, relative L1 in %, at texel centres | midway between texels (the worse of x and y){}\n"
      "  level    texels",
      group_text(brdfs.front()), has_intervals ? "; +- 95 % interval" : "");
  const auto column = [&](const AccuracyBrdf& brdf) {
    return std::max<std::size_t>(has_intervals ? 32 : 20, brdf.brdf_text().size() + 2);
  };
  for (const AccuracyBrdf& brdf : brdfs) text += fmt::format("{:>{}}", brdf.brdf_text(), column(brdf));
  text += "\n";
  for (const auto& [fitted_level, confidence] : confidences) {
    const int level = fitted_level;  // C++20 with clang 14 captures no structured binding
    text += fmt::format("  {:>5}  {:>8}", level, texels_text(confidence));
    for (const AccuracyBrdf& brdf : brdfs) {
      const auto found = [&](AccuracyPoint point) { return find_row(rows, level, point, brdf); };
      const AccuracyRow* centre = found(AccuracyPoint::kCentre);
      const AccuracyRow* midway = worse(found(AccuracyPoint::kMidX), found(AccuracyPoint::kMidY));
      text += fmt::format("{:>{}}", centre == nullptr ? "-" : percent_text(centre) + " | " + percent_text(midway),
                          column(brdf));
    }
    text += "\n";
  }
  return text;
}

constexpr const char* kPixels = "pixels";  // replaces the name of a point
constexpr int kNoLevel = -1;

nlohmann::json entry_of(const FootprintError& one) {
  return {kNoLevel,
          kPixels,
          one.brdf.text(),
          rounded(one.error),
          millionths_up(one.confidence) / 1e6,
          rounded(one.percentile_95),
          one.worst_octave,
          rounded(one.worst_octave_error),
          one.sample_count};
}

std::optional<FootprintError> parse_footprint_error(const nlohmann::json& one) {
  if (one.size() != 9 || !one[2].is_string() || !one[6].is_number_integer() || !one[8].is_number_integer())
    return std::nullopt;
  for (const std::size_t i : {3, 4, 5, 7})
    if (!one[i].is_number() || !(one[i].get<double>() >= 0.0)) return std::nullopt;
  const auto octave = one[6].get<std::int64_t>();
  if (octave < 0 || octave > kLevelMax) return std::nullopt;
  return FootprintError{parse_accuracy_brdf(one[2].get<std::string>()),
                        one[3].get<double>(),
                        one[4].get<double>(),
                        one[5].get<double>(),
                        static_cast<int>(octave),
                        one[7].get<double>(),
                        one[8].get<std::int64_t>()};
}

std::optional<AccuracyPoint> parse_point(const std::string& name) {
  for (const AccuracyPoint point :
       {AccuracyPoint::kCentre, AccuracyPoint::kMidX, AccuracyPoint::kMidY, AccuracyPoint::kBetween})
    if (name == accuracy_point_name(point)) return point;
  return std::nullopt;
}

}  // namespace

std::string footprint_error_text(const std::vector<FootprintError>& errors) {
  if (errors.empty()) return "";
  std::size_t width = 0;
  for (const FootprintError& one : errors) width = std::max(width, one.brdf.text().size());
  std::string text = "relative L1 error of pixels with its 95 % interval\n";
  for (const FootprintError& one : errors)
    text += fmt::format(
        "  {:<{}}  {:.2f} +- {:.2f} %; 95 % of pixels within {:.2f} %; worst: {:.2f} % for pixels that cover {}\n",
        one.brdf.text(), width, 100.0 * rounded(one.error), hundredths_of_percent_up(one.confidence) / 100.0,
        100.0 * rounded(one.percentile_95), 100.0 * rounded(one.worst_octave_error), octave_text(one.worst_octave));
  return text;
}

std::string accuracy_table(const std::vector<AccuracyRow>& rows) {
  std::vector<std::vector<AccuracyBrdf>> groups;  // BRDFs grouped by shading method, in the given order
  for (const AccuracyRow& row : rows) {
    auto group = std::find_if(groups.begin(), groups.end(),
                              [&](const auto& brdfs) { return is_shaded_alike(brdfs.front(), row.brdf); });
    if (group == groups.end()) groups.push_back({row.brdf});
    else if (std::find(group->begin(), group->end(), row.brdf) == group->end()) group->push_back(row.brdf);
  }
  std::string text;
  for (const std::vector<AccuracyBrdf>& brdfs : groups) text += table(rows, brdfs);
  return text;
}

std::string measured_error_json(const std::vector<AccuracyRow>& rows, const std::vector<FootprintError>& errors) {
  nlohmann::json json = nlohmann::json::array();
  for (const FootprintError& one : errors) json.push_back(entry_of(one));
  for (const AccuracyRow& row : rows) {
    nlohmann::json one = {row.level, accuracy_point_name(row.point), row.brdf.text(), rounded(row.error)};
    if (row.confidence == 0.0) one.push_back(0);
    else if (row.confidence > 0.0) one.push_back(millionths_up(row.confidence) / 1e6);
    json.push_back(std::move(one));
  }
  return json.dump();
}

std::optional<StatedErrors> parse_measured_error(const std::string& text) {
  const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);  // no exceptions
  if (!json.is_array()) return std::nullopt;
  StatedErrors stated;
  for (const nlohmann::json& one : json) {
    if (one.is_array() && one.size() > 1 && one[1] == kPixels) {
      const std::optional<FootprintError> error = parse_footprint_error(one);
      if (!error) return std::nullopt;
      stated.footprint_errors.push_back(*error);
      continue;
    }
    if (!one.is_array() || one.size() < 4 || one.size() > 5 || !one[0].is_number_integer() || !one[1].is_string() ||
        !one[2].is_string() || !one[3].is_number())
      return std::nullopt;
    if (one.size() == 5 && !(one[4].is_number() && one[4].get<double>() >= 0.0)) return std::nullopt;
    const double confidence = one.size() == 5 ? one[4].get<double>() : kIntervalUnstated;
    const auto level = one[0].get<std::int64_t>();
    const std::optional<AccuracyPoint> point = parse_point(one[1].get<std::string>());
    if (level < 0 || level > kLevelMax || !point) return std::nullopt;
    stated.rows.push_back({static_cast<int>(level), *point, parse_accuracy_brdf(one[2].get<std::string>()),
                           one[3].get<double>(), confidence, 0});
  }
  return stated;
}

}  // namespace multum
