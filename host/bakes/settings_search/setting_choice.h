// SPDX-License-Identifier: Apache-2.0
// Chooses the settings that a map needs: tries candidates (host/bakes/settings_search/setting_candidates.h) in the
// order of their cost on a mosaic of the map (host/bakes/settings_search/map_mosaic.h) until one is near enough to the
// reference. Nothing is written here; the bake that follows says whether the whole map keeps what the mosaic promised
// (host/bakes/settings_search/chosen_bake.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_source.h"
#include "host/bakes/settings_search/setting_candidates.h"

namespace multum {

/// BRDF whose error counts; "roughness" for a bake with a roughness map.
struct TargetBrdf {
  AccuracyBrdf id = AccuracyBrdf::blinn_phong(100.0);  // without a way to shade it, and without colours
  std::string text = id.text();                        // as options name it
  Brdf brdf;                                           // kLambert: no highlight

  bool has_highlight() const { return brdf.kind != BrdfKind::kLambert; }
  /// Is it shaded as a sum of vMFs?
  bool is_sum() const { return is_vmf_sum(brdf); }
  bool can_shade(Representation r) const { return !is_sum() || representation_info(r).takes_every_brdf; }
  /// Its highlight, unless every bake measures it.
  std::vector<Highlight> more_highlights() const;
};
/// Parses a BRDF as parse_brdf() does; the highlight alone counts. Throws Error(kUsage) naming `option`, Error(kInput).
TargetBrdf parse_target_brdf(const std::string& text, const std::string& option = "--brdf");

/// The least error of `brdf` among the ways to shade a file; with colours where the file has them.
struct ReachedError {
  double error = 0.0;
  double confidence = 0.0;  // half width of the 95 % interval
  double percentile_95 = 0.0;
  int worst_octave = 0;
  double worst_octave_error = 0.0;
  std::string shading;  // "lean", of moments; else empty

  /// Below `error`, its interval and all?
  bool meets(double target) const { return error + confidence <= target; }
};
ReachedError reached_error(const std::vector<FootprintError>& errors, const TargetBrdf& brdf);

/// Error and time of a candidate on the mosaic.
struct SettingTrial {
  std::size_t candidate;
  ReachedError reached;
  double seconds;        // of the fit or of averaging
  double fixed_seconds;  // of these, what does not grow with the map: choosing a start, and coarse levels
};

/// Trials of one map, each made when it is asked for, once.
class SettingTrials {
 public:
  /// `source` and `device` must outlive it.
  SettingTrials(Device& device, const BakeJob& job, const BakeSource& source, TargetBrdf brdf,
                std::vector<SettingCandidate> candidates);

  const std::vector<SettingCandidate>& candidates() const { return candidates_; }
  const TargetBrdf& brdf() const { return brdf_; }
  /// Of the target: one, or none.
  const std::vector<Highlight>& highlights() const { return highlights_; }
  /// Throws Cancelled.
  const SettingTrial& at(std::size_t candidate, Progress* progress);
  /// Trials that were made, in that order.
  const std::vector<SettingTrial>& made() const { return made_; }
  /// Texels of the map per texel of the mosaic.
  double scale() const;

 private:
  Device& device_;
  const BakeJob job_;
  const TargetBrdf brdf_;
  const std::vector<Highlight> highlights_;  // of it: one, or none
  const BakeSource mosaic_;
  const std::vector<SettingCandidate> candidates_;
  std::vector<SettingTrial> made_;
  double scale_;
};

/// JOB with a candidate's settings in the place of its own.
BakeJob with_candidate(const BakeJob& job, const SettingCandidate& candidate);

/// The cheapest candidate, from number `first` on, that reaches `error` on the mosaic, its interval included, when
/// mosaic errors are multiplied by `correction`; nullopt where none does. Candidates whose quicker variant is too far
/// off are not tried: as many lobes fitted longer take a quarter off the error at most.
std::optional<SettingTrial> cheapest_within(SettingTrials& trials, double error, double correction, std::size_t first,
                                            Progress* progress);

}  // namespace multum
