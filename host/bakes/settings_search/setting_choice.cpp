// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/setting_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/settings_search/map_mosaic.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/leading_number.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

constexpr int kFinestFitted = 1;  // level 1, because level 0 has one direction per texel

}  // namespace

TargetBrdf parse_target_brdf(const std::string& text, const std::string& option) {
  const Brdf brdf = parse_brdf(option, text, Brdf().term_count);
  if (const std::string refusal = measuring_refusal(brdf); !refusal.empty())
    throw Error(ErrorCode::kUsage, option + ": " + refusal);
  switch (brdf.kind) {
    case BrdfKind::kLambert: return {AccuracyBrdf::lambert(), text, brdf};
    case BrdfKind::kBlinnPhong:
      return {AccuracyBrdf::blinn_phong(leading_number(text.substr(text.find(':') + 1)).value()), text, brdf};
    default: return {AccuracyBrdf::named(text), text, brdf};
  }
}

std::vector<Highlight> TargetBrdf::more_highlights() const {
  const std::vector<double> exponents = AccuracySettings().exponents;
  const bool is_default =
      brdf.kind == BrdfKind::kBlinnPhong &&
      std::find(exponents.begin(), exponents.end(), static_cast<double>(brdf.exponent)) != exponents.end();
  if (!has_highlight() || is_default) return {};
  return {make_highlight(id, brdf)};
}

ReachedError reached_error(const std::vector<FootprintError>& errors, const TargetBrdf& brdf) {
  const bool has_colours =
      std::any_of(errors.begin(), errors.end(), [](const FootprintError& one) { return one.brdf.has_colours; });
  std::optional<ReachedError> best;
  for (const FootprintError& one : errors) {
    if (one.brdf.has_colours != has_colours || !one.brdf.is_same_brdf(brdf.id)) continue;
    if (best && !(one.error < best->error)) continue;
    best = {one.error, one.confidence, one.percentile_95, one.worst_octave, one.worst_octave_error, one.brdf.shading};
  }
  MULTUM_CHECK(best.has_value());
  return *best;
}

BakeJob with_candidate(const BakeJob& job, const SettingCandidate& candidate) {
  BakeJob chosen = job;
  apply(candidate.values, chosen);
  return chosen;
}

SettingTrials::SettingTrials(Device& device, const BakeJob& job, const BakeSource& source, TargetBrdf brdf,
                             std::vector<SettingCandidate> candidates)
    : device_(device),
      job_(job),
      brdf_(std::move(brdf)),
      highlights_(brdf_.has_highlight() ? std::vector{make_highlight(brdf_.id, brdf_.brdf)} : std::vector<Highlight>()),
      mosaic_(make_mosaic(source, {})),
      candidates_(std::move(candidates)),
      scale_(static_cast<double>(source.map.normals.width()) * source.map.normals.height() /
             (static_cast<double>(mosaic_.map.normals.width()) * mosaic_.map.normals.height())) {}

double SettingTrials::scale() const { return scale_; }

const SettingTrial& SettingTrials::at(std::size_t candidate, Progress* progress) {
  for (const SettingTrial& trial : made_)
    if (trial.candidate == candidate) return trial;
  const BakeJob job = with_candidate(job_, candidates_.at(candidate));
  AccuracySettings accuracy;
  accuracy.has_level_table = false;
  accuracy.first_level = first_measured_level(job);
  accuracy.exponents.clear();
  accuracy.highlights = highlights_;
  BakeReport report;
  Progress quiet = cancel_only(progress);
  const std::unique_ptr<AccuracyMeter> meter = try_levels(device_, job, mosaic_, accuracy, report, &quiet);
  meter->run(device_, mosaic_.map.normals, mosaic_.colours(), &quiet);
  const ReachedError reached = reached_error(meter->footprint_errors(), brdf_);
  double fixed_seconds = report.fit.start_seconds;
  for (const LevelReport& level : report.fit.levels)
    if (level.level > std::max(job.fitting.first_level, kFinestFitted)) fixed_seconds += level.seconds;
  made_.push_back({candidate, reached, report.bake_seconds(), fixed_seconds});
  log_verbose(fmt::format("trial: {:<44} {} in {:.3f} s", candidates_[candidate].options,
                          error_text(reached.error, reached.confidence), report.bake_seconds()));
  return made_.back();
}

std::optional<SettingTrial> cheapest_within(SettingTrials& trials, double error, double correction, std::size_t first,
                                            Progress* progress) {
  // On 16 maps with 8 lobe counts each, the error decreased by at most 22 %, and in half of the cases by less than 0.2
  // %.
  constexpr double kEffortGain = 0.25;
  const std::vector<SettingCandidate>& candidates = trials.candidates();
  const auto is_hopeless = [&](const SettingCandidate& one) {
    return std::any_of(trials.made().begin(), trials.made().end(), [&](const SettingTrial& made) {
      const SettingCandidate& other = candidates[made.candidate];
      return other.representation() == one.representation() && other.texture_count == one.texture_count &&
             other.effort < one.effort && made.reached.error * correction * (1.0 - kEffortGain) > error;
    });
  };
  for (std::size_t i = first; i < candidates.size(); ++i) {
    if (is_hopeless(candidates[i])) continue;
    const SettingTrial& trial = trials.at(i, progress);
    if ((trial.reached.error + trial.reached.confidence) * correction <= error) return trial;
  }
  return std::nullopt;
}

}  // namespace multum
