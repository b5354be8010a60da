// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/chosen_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <memory>

#include "host/bakes/bake/bake_file.h"
#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/bake/output_state.h"
#include "host/bakes/settings_search/plane_picture.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/held_warnings.h"

namespace multum {
namespace {

// A bake of the whole map.
struct Attempt {
  SettingTrial trial;
  ReachedError reached;                   // error that the bake measured
  std::optional<ReachedError> confirmed;  // error at other footprints, measured if the target was reached
  double seconds;

  const ReachedError& judged() const { return confirmed ? *confirmed : reached; }
  BakeReport report;
  std::vector<std::string> warnings;  // warnings, which are printed if this attempt is chosen
};

// Bakes candidates in a temporary folder next to the output. The folder is removed at the end, unless it holds a
// stopped bake that can be resumed.
class Attempts {
 public:
  Attempts(const BakeJob& job, const BakeSource& source, SettingTrials& trials, double read_seconds, Device& device,
           Progress* progress)
      : job_(job),
        source_(source),
        trials_(trials),
        read_seconds_(read_seconds),
        device_(device),
        progress_(progress),
        work_(WorkFolder::take(partial_folder_of(job.output))) {
    if (!work_) throw Error(ErrorCode::kEnvironment, job.output + ": another process is writing it");
    scratch_ = work_->path() + "/chosen.exr";
    kept_ = work_->path() + "/kept.exr";
  }
  Attempts(const Attempts&) = delete;
  Attempts& operator=(const Attempts&) = delete;
  ~Attempts() {
    std::error_code ignored;
    std::filesystem::remove(scratch_, ignored);
    std::filesystem::remove(kept_, ignored);
    if (std::filesystem::exists(partial_folder_of(scratch_), ignored)) work_->leave();
  }

  /// `may_meet` is false for a file that is kept although it misses the target. Later bakes must not recognise such a
  /// file as one that meets the target.
  const Attempt& bake(const SettingTrial& trial, bool may_meet = true) {
    BakeJob job = with_candidate(job_, trials_.candidates()[trial.candidate]);
    if (!may_meet) job.chosen_for.clear();
    job.output = scratch_;
    job.report.clear();
    job.force = true;
    const TargetBrdf& brdf = trials_.brdf();
    if (!source_.has_roughness()) job.highlights = brdf.more_highlights();
    HeldWarnings held;
    BakeReport report = bake_file(job, &source_, device_, progress_);
    report.stages.insert(report.stages.begin(), {"read", read_seconds_});
    made_.push_back({trial, reached_error(report.error, brdf), std::nullopt, report.bake_seconds(), std::move(report),
                     held.take()});
    return made_.back();
  }
  /// Returns whether the last attempt meets the target. If it seems to meet the target, its file is measured again at
  /// other footprints.
  bool meets(double target) {
    constexpr std::uint64_t kSecondSeed = 1000003;
    Attempt& attempt = made_.back();
    if (!attempt.reached.meets(target)) return false;
    BakeJob job = with_candidate(job_, trials_.candidates()[attempt.trial.candidate]);
    job.output = scratch_;
    AccuracySettings accuracy;
    accuracy.threads = job.threads;
    accuracy.has_level_table = false;
    accuracy.seed = kSecondSeed;
    accuracy.exponents.clear();
    accuracy.highlights = trials_.highlights();
    accuracy.first_level = first_measured_level(job);
    Progress quiet = cancel_only(progress_);
    const VerifiedFile file = ndf_bake(job.representation).verify(job, accuracy, &quiet);
    file.meter->run(device_, source_.map.normals, source_.colours(), &quiet);
    attempt.confirmed = reached_error(file.meter->footprint_errors(), trials_.brdf());
    return attempt.confirmed->meets(target);
  }
  /// Selects the file of the last attempt as the output, unless another file is kept later.
  void keep() {
    std::filesystem::rename(scratch_, kept_);
    has_kept_ = true;
  }
  /// Renames the kept file to the output. Call this function last, so that a cancelled search leaves an older output
  /// unchanged.
  void commit() {
    if (has_kept_) std::filesystem::rename(kept_, job_.output);
    has_kept_ = false;
  }
  const std::vector<Attempt>& made() const { return made_; }
  bool has(std::size_t candidate) const {
    return std::any_of(made_.begin(), made_.end(),
                       [&](const Attempt& one) { return one.trial.candidate == candidate; });
  }

 private:
  const BakeJob& job_;
  const BakeSource& source_;
  SettingTrials& trials_;
  const double read_seconds_;
  Device& device_;
  Progress* progress_;
  const std::unique_ptr<WorkFolder> work_;
  std::string scratch_, kept_;
  bool has_kept_ = false;
  std::vector<Attempt> made_;
};

std::string in_percent(double share) { return fmt::format("{:.4g} %", 100.0 * share); }

std::string reached_text(const ReachedError& reached) {
  return error_text(reached.error, reached.confidence) +
         (reached.shading.empty() ? "" : fmt::format(" when shaded as {}", reached.shading));
}

// Tries the cheapest settings first. Errors that were measured on the whole map correct the predictions of the mosaic.
std::optional<std::size_t> find_by_error(const BakeTarget& target, SettingTrials& trials, Attempts& attempts,
                                         Progress* progress) {
  double correction = 1.0;
  for (std::size_t first = 0;;) {
    const std::optional<SettingTrial> trial = cheapest_within(trials, *target.error, correction, first, progress);
    if (!trial) break;
    const Attempt& attempt = attempts.bake(*trial);
    if (attempts.meets(*target.error)) return attempts.made().size() - 1;
    first = trial->candidate + 1;
    if (trial->reached.error > 0.0) correction = std::max(correction, attempt.judged().error / trial->reached.error);
  }
  // The mosaic is only a sample of the map, so the settings that are best on the mosaic are also baked.
  const auto best =
      std::min_element(trials.made().begin(), trials.made().end(),
                       [](const SettingTrial& a, const SettingTrial& b) { return a.reached.error < b.reached.error; });
  if (attempts.has(best->candidate)) return std::nullopt;
  attempts.bake(SettingTrial(*best));
  if (attempts.meets(*target.error)) return attempts.made().size() - 1;
  return std::nullopt;
}

// Predicts the time of a bake of the whole map from its trial. The map has `scale` times as many texels on level 1, the
// finest level that the trial fits. The times of finished bakes correct the prediction, separately for lobes and for
// averages.
class TimeGuess {
 public:
  TimeGuess(const SettingTrials& trials, double read_seconds) : trials_(trials), read_seconds_(read_seconds) {}
  double seconds(const SettingTrial& trial) const {
    constexpr double kDefaultCorrection = 0.75;  // trials are so small that the time for launches matters
    const auto found = correction_.find(is_fit(trial));
    return read_seconds_ + raw(trial) * (found == correction_.end() ? kDefaultCorrection : found->second);
  }
  void learn(const Attempt& attempt) {
    correction_[is_fit(attempt.trial)] = (attempt.seconds - read_seconds_) / std::max(1e-6, raw(attempt.trial));
  }

 private:
  bool is_fit(const SettingTrial& trial) const {
    return holds_lobes(trials_.candidates()[trial.candidate].representation());
  }
  double raw(const SettingTrial& trial) const {
    return trial.fixed_seconds + (trial.seconds - trial.fixed_seconds) * trials_.scale();
  }

  const SettingTrials& trials_;
  const double read_seconds_;
  std::map<bool, double> correction_;
};

// Bakes settings that are predicted to be fast enough, the lowest error first. Stops when a bake is fast enough and no
// better one is expected.
std::optional<std::size_t> find_by_time(const BakeTarget& target, double read_seconds, SettingTrials& trials,
                                        Attempts& attempts, Progress* progress) {
  constexpr std::size_t kAttemptsMax = 6;
  // Predicted times may be too high, but by at most this factor. If the time of a trial exceeds the target by more than
  // this factor, settings of the same representation with more lobes or higher orders are skipped.
  constexpr double kGuessMargin = 8.0;
  TimeGuess guess(trials, read_seconds);
  const std::vector<SettingCandidate>& candidates = trials.candidates();
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const bool is_too_slow = std::any_of(trials.made().begin(), trials.made().end(), [&](const SettingTrial& made) {
      const SettingCandidate& other = candidates[made.candidate];
      return other.representation() == candidates[i].representation() && other.effort <= candidates[i].effort &&
             guess.seconds(made) > kGuessMargin * *target.seconds;
    });
    if (!is_too_slow) trials.at(i, progress);
  }
  std::optional<std::size_t> best;
  while (attempts.made().size() < kAttemptsMax) {
    const SettingTrial* next = nullptr;
    const SettingTrial* fastest = nullptr;
    for (const SettingTrial& trial : trials.made()) {
      if (attempts.has(trial.candidate)) continue;
      if (fastest == nullptr || guess.seconds(trial) < guess.seconds(*fastest)) fastest = &trial;
      const bool is_better = next == nullptr || trial.reached.error < next->reached.error;
      if (is_better && guess.seconds(trial) <= *target.seconds) next = &trial;
    }
    if (best && (next == nullptr || next->reached.error >= attempts.made()[*best].trial.reached.error)) break;
    if (next == nullptr) next = fastest;
    if (next == nullptr) break;
    const Attempt& attempt = attempts.bake(SettingTrial(*next));
    log_verbose(fmt::format("baked: {} in {:.3f} s, predicted {:.3f} s", candidates[next->candidate].options,
                            attempt.seconds, guess.seconds(*next)));
    guess.learn(attempt);
    if (attempt.seconds > *target.seconds) continue;
    attempts.keep();
    best = attempts.made().size() - 1;
  }
  return best;
}

// Describes the chosen settings, the reason for the choice, and the other trials.
std::string choice_text(const BakeTarget& target, const SettingTrials& trials, const Attempts& attempts,
                        const Attempt& chosen, bool met) {
  const auto options = [&](const SettingTrial& trial) { return trials.candidates()[trial.candidate].options; };
  std::string text = fmt::format("{}: {}: {} for {}", met ? "chosen" : "best reached", options(chosen.trial),
                                 reached_text(chosen.judged()), trials.brdf().id.text());
  text += target.error ? fmt::format(", asked for {}", in_percent(*target.error))
                       : fmt::format(" in {:.0f} ms, asked for {:.0f}", 1e3 * chosen.seconds, 1e3 * *target.seconds);
  text += fmt::format("; tried {} of {} settings on a mosaic, and baked with {}\n", trials.made().size(),
                      trials.candidates().size(), attempts.made().size());
  if (target.error) {
    // States the error of the most accurate cheaper settings, to show that no cheaper settings suffice.
    const SettingTrial* below = nullptr;
    for (const SettingTrial& trial : trials.made())
      if (trial.candidate < chosen.trial.candidate && (!below || trial.reached.error < below->reached.error))
        below = &trial;
    if (met && below != nullptr)
      text += fmt::format("  the best cheaper settings have an error of {} ({})\n", in_percent(below->reached.error),
                          options(*below));
  }
  const ReachedError& judged = chosen.judged();
  if (chosen.confirmed)
    text += fmt::format(
        "  measured at footprints that were not used to choose the settings; the error at the footprints that were "
        "used is {}\n",
        error_text(chosen.reached.error, chosen.reached.confidence));
  text += fmt::format("  95 % of pixels have errors of at most {}; the worst pixels cover {} and have an error of {}\n",
                      in_percent(judged.percentile_95), octave_text(judged.worst_octave),
                      in_percent(judged.worst_octave_error));
  return text;
}

// Adds the error of a picture of the output. The picture is optional, so that the file can be written on a machine
// without GL.
void add_picture(const BakeJob& job, const BakeTarget& target, Progress* progress, BakeReport& report) {
  if (target.viewer.program.empty()) return;
  try {
    progress_stage(progress, "draw");
    report.picture_error = draw_plane(job, target.brdf, target.viewer, progress);
    report.choice +=
        fmt::format("  a picture of a plane up to the horizon has an error of {}\n", in_percent(*report.picture_error));
  } catch (const Error& error) {
    log_verbose(fmt::format("no picture of {}: {}", job.output, error.what()));
  }
}

}  // namespace

void check_target(const BakeTarget& target, const BakeJob& job) {
  if (target.error.has_value() == target.seconds.has_value())
    throw Error(ErrorCode::kUsage, "--target-error and --budget-ms: expected only one of them");
  if (target.error && !(*target.error > 0.0 && *target.error <= 2.0))
    throw Error(
        ErrorCode::kUsage,
        fmt::format("--target-error is {:g}, expected a number above 0, at most 2: 0.1 is a relative L1 error of 10 %",
                    *target.error));
  if (target.seconds && !(*target.seconds > 0.0))
    throw Error(ErrorCode::kUsage,
                fmt::format("--budget-ms is {:g}, expected a number above 0", 1e3 * *target.seconds));
  if (target.only && !target.brdf.can_shade(*target.only))
    throw Error(ErrorCode::kUsage, fmt::format("--brdf {} is a sum of vMFs, which --ndf {} cannot shade",
                                               target.brdf.text, representation_info(*target.only).option));
  if (!job.measure)
    throw Error(ErrorCode::kUsage,
                "--no-measure cannot be combined with --target-error or --budget-ms, because these choose settings by "
                "measured errors");
  if (job.region || !job.onto.empty())
    throw Error(ErrorCode::kUsage,
                "--region and --onto use the settings of an existing file, so --target-error and --budget-ms cannot "
                "choose settings");
  if (job.resume && target.seconds)
    throw Error(ErrorCode::kUsage,
                "--resume and --budget-ms are mutually exclusive, because the time of a resumed bake does not show the "
                "cost of its settings");
}

ChosenBake bake_to_target(const BakeJob& job, const BakeTarget& target, Device& device, Progress* progress) {
  return bake_to_target(job, target, nullptr, device, progress);
}

std::string target_text(const BakeTarget& target) {
  std::string text = target.error ? fmt::format("an error of {:g}", *target.error)
                                  : fmt::format("a bake of {:g} ms", 1e3 * *target.seconds);
  text += fmt::format(" for {}", target.brdf.id.text());
  if (target.only) text += fmt::format(" by {}", representation_info(*target.only).option);
  return text;
}

std::string target_key(const BakeJob& job, const BakeTarget& target) {
  std::string rest = all_settings_json(job);
  if (is_brdf_file(target.brdf.text)) rest += job.hashes->hash(target.brdf.text);
  return fmt::format("{}, {}", target_text(target), hash_text(rest).substr(0, 16));
}

ChosenBake bake_to_target(const BakeJob& given_job, const BakeTarget& given, const BakeSource* given_source,
                          Device& device, Progress* progress) {
  check_target(given, given_job);
  check_job(given_job);
  BakeJob job = given_job;
  job.chosen_for = target_key(given_job, given);
  if (!job.force && find_output_state(job, all_settings_json(job)).finding == OutputFinding::kInPlace) {
    ChosenBake in_place;
    in_place.report = unchanged_report(job);
    in_place.met = in_place.written = true;
    return in_place;
  }
  BakeTarget target = given;
  BakeReport choosing;
  StageClock clock(choosing);
  std::optional<BakeSource> read;
  if (given_source == nullptr) read = read_source(job, MapReadings::kMany, choosing, progress);
  const BakeSource& source = given_source != nullptr ? *given_source : *read;
  clock.finish("read");
  if (source.has_roughness() && target.brdf.id != AccuracyBrdf::lambert()) target.brdf.id = AccuracyBrdf::roughness();
  std::vector<SettingCandidate> candidates = target_candidates(target.only);
  std::erase_if(candidates, [&](const SettingCandidate& one) { return !one.is_for(job); });
  // These representations cannot shade sums of vMFs or highlights of varying width.
  if (!target.only && (target.brdf.is_sum() || source.has_roughness()))
    std::erase_if(candidates, [&](const SettingCandidate& one) {
      return !representation_info(one.representation()).takes_every_brdf;
    });
  progress_stage(progress, "choose settings");
  SettingTrials trials(device, job, source, target.brdf, std::move(candidates));
  const double read_seconds = choosing.bake_seconds();
  Attempts attempts(job, source, trials, read_seconds, device, progress);
  const std::optional<std::size_t> found = target.error
                                               ? find_by_error(target, trials, attempts, progress)
                                               : find_by_time(target, read_seconds, trials, attempts, progress);
  ChosenBake chosen;
  chosen.met = found.has_value();
  std::size_t best = found.value_or(0);
  if (!found) {
    const auto better = [&](const Attempt& a, const Attempt& b) {
      return target.error ? a.judged().error < b.judged().error : a.seconds < b.seconds;
    };
    best = static_cast<std::size_t>(std::min_element(attempts.made().begin(), attempts.made().end(), better) -
                                    attempts.made().begin());
    if (target.best_effort)
      attempts.bake(SettingTrial(attempts.made()[best].trial), false), best = attempts.made().size() - 1;
  }
  if ((target.error && chosen.met) || (!chosen.met && target.best_effort)) attempts.keep();
  attempts.commit();
  const Attempt& attempt = attempts.made()[best];
  chosen.report = attempt.report;
  chosen.reached = attempt.judged();
  chosen.options = trials.candidates()[attempt.trial.candidate].options;
  chosen.report.choice = choice_text(target, trials, attempts, attempt, chosen.met);
  chosen.written = chosen.met || target.best_effort;
  if (chosen.written) add_picture(job, target, progress, chosen.report);
  if (chosen.written)
    for (const std::string& warning : attempt.warnings) log_named_warning(warning);
  clock.finish("choose");
  // The time that is not part of the bake itself.
  double others = choosing.stages.back().seconds;
  for (const StageTime& stage : chosen.report.stages)
    if (stage.name != "read") others -= stage.seconds;
  chosen.report.stages.insert(chosen.report.stages.begin() + 1, {"choose", std::max(0.0, others)});
  if (chosen.written && !job.report.empty()) write_text_file(job.report, chosen.report.to_json());
  return chosen;
}

}  // namespace multum
