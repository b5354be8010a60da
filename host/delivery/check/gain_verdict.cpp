// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/check/gain_verdict.h"

#include <fmt/format.h>

#include <algorithm>

#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

// A form is worth the work if it lowers the error by at least this many percentage points, and by this share.
constexpr double kWorthPoints = 1.0, kWorthShare = 0.1;
constexpr double kFlatPoints = 1.0;        // if plain mips have at most this error everywhere, the map is flat
constexpr double kSentenceDistance = 5.0;  // metres, if a form is worth it there

// Mean errors under all lights, from one distance.
struct DistanceError {
  double distance = 0.0, plain = 0.0, exported = 0.0, lobes = 0.0;

  double best() const { return std::min({plain, exported, lobes}); }
};

bool is_worth(double before, double after) { return before - after >= std::max(kWorthPoints, kWorthShare * before); }

std::vector<DistanceError> mean_errors(const GainVerdict& verdict) {
  std::vector<DistanceError> made;
  std::vector<int> counts;
  for (const GainError& error : verdict.measured) {
    if (error.roughness != verdict.roughness) continue;
    if (made.empty() || made.back().distance != error.distance) {
      made.push_back({error.distance});
      counts.push_back(0);
    }
    DistanceError& at = made.back();
    at.plain += error.plain;
    at.exported += error.exported;
    at.lobes += error.lobes;
    ++counts.back();
  }
  for (std::size_t i = 0; i < made.size(); ++i)
    for (double* value : {&made[i].plain, &made[i].exported, &made[i].lobes}) *value /= counts[i];
  return made;
}

// Returns the distance of the sentence: the usual one if a form is worth it there, or else the one with the largest
// gain.
const DistanceError& quoted(const std::vector<DistanceError>& errors) {
  const auto usual = std::find_if(errors.begin(), errors.end(),
                                  [](const DistanceError& at) { return at.distance == kSentenceDistance; });
  if (usual != errors.end() && is_worth(usual->plain, usual->best())) return *usual;
  return *std::max_element(errors.begin(), errors.end(), [](const DistanceError& a, const DistanceError& b) {
    return a.plain - a.best() < b.plain - b.best();
  });
}

// Return the first distance from which a form is worth it. The export is compared with plain mips, and lobes with the
// better of the two.
std::optional<double> export_worth_from(const std::vector<DistanceError>& errors) {
  for (const DistanceError& at : errors)
    if (is_worth(at.plain, at.exported)) return at.distance;
  return std::nullopt;
}
std::optional<double> lobes_worth_from(const std::vector<DistanceError>& errors) {
  for (const DistanceError& at : errors)
    if (is_worth(std::min(at.plain, at.exported), at.lobes)) return at.distance;
  return std::nullopt;
}

std::string from_text(const std::vector<DistanceError>& errors, double distance) {
  return distance == errors.front().distance ? "from any distance" : fmt::format("from {:.3g} m on", distance);
}

const char* advice_name(GainAdvice advice) {
  switch (advice) {
    case GainAdvice::kKeep: return "keep";
    case GainAdvice::kExport: return "export";
    case GainAdvice::kLobes: return "lobes";
  }
  return "";
}

const char* light_name(GainLight light) { return light == GainLight::kSun ? "sun" : "sky"; }

}  // namespace

GainAdvice GainVerdict::advice() const {
  const std::vector<DistanceError> means = mean_errors(*this);
  if (lobes_worth_from(means)) return GainAdvice::kLobes;
  return export_worth_from(means) ? GainAdvice::kExport : GainAdvice::kKeep;
}

double GainVerdict::gain() const {
  double gain = 0.0;
  for (const DistanceError& at : mean_errors(*this)) gain = std::max(gain, at.plain - at.best());
  return gain;
}

std::string GainVerdict::to_text() const {
  if (!kept.empty()) return kept;
  const std::vector<DistanceError> means = mean_errors(*this);
  double most = 0.0;
  for (const DistanceError& at : means) most = std::max(most, at.plain);
  if (most <= kFlatPoints) return fmt::format("flat: keep your mips (their error is at most {:.1f} %)", most);
  const DistanceError& at = quoted(means);
  std::string text = fmt::format("at {:.3g} m", at.distance);
  if (roughness) text += fmt::format(" and roughness {:.2g}", *roughness);
  text += fmt::format(": plain mips {:.1f} %, export {:.1f} %, lobes {:.1f} %; ", at.plain, at.exported, at.lobes);
  const std::optional<double> exported = export_worth_from(means), lobes = lobes_worth_from(means);
  if (!exported && !lobes) return text + "keep your mips";
  if (exported) text += fmt::format("the export is worth it {}", from_text(means, *exported));
  if (exported && lobes) text += ", ";
  if (lobes) text += fmt::format("lobes are worth it {}", from_text(means, *lobes));
  return text;
}

std::string GainVerdict::to_table() const {
  std::string text = fmt::format("  {:>8} {:>10} {:>6} {:>8} {:>8} {:>8}\n", "distance", "roughness", "light", "plain",
                                 "export", "lobes");
  for (const GainError& error : measured)
    text += fmt::format("  {:>6.3g} m {:>10} {:>6} {:>6.1f} % {:>6.1f} % {:>6.1f} %\n", error.distance,
                        error.roughness ? fmt::format("{:.2g}", *error.roughness) : "of map", light_name(error.light),
                        error.plain, error.exported, error.lobes);
  return text;
}

nlohmann::ordered_json GainVerdict::to_json() const {
  nlohmann::ordered_json made = {{"name", text_of_path(name)}, {"sentence", to_text()}};
  if (!kept.empty()) return made;
  made["advice"] = advice_name(advice());
  made["gain"] = gain();
  for (const GainError& error : measured) {
    nlohmann::ordered_json row = {{"distance", error.distance}, {"roughness", nullptr}};
    if (error.roughness) row["roughness"] = *error.roughness;
    row.update({{"light", light_name(error.light)},
                {"plain", error.plain},
                {"export", error.exported},
                {"lobes", error.lobes},
                {"noise", error.noise}});
    made["errors"].push_back(std::move(row));
  }
  return made;
}

}  // namespace multum
