// SPDX-License-Identifier: Apache-2.0
// Chooses the settings for a map. Tries candidates (host/bakes/settings_search/setting_candidates.h) in order of
// increasing cost on a mosaic of the map (host/bakes/settings_search/map_mosaic.h), until the error of a candidate is
// low enough. No file is written. The bake that follows checks whether the whole map has the error that the mosaic
// predicts (host/bakes/settings_search/chosen_bake.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/bakes/bake/bake_job.h"
#include "host/bakes/bake/bake_source.h"
#include "host/bakes/settings_search/setting_candidates.h"

namespace multum {

/// The BRDF of the target error, which is "roughness" for a bake with a roughness map.
struct TargetBrdf {
  AccuracyBrdf id = AccuracyBrdf::blinn_phong(100.0);  // without shading method and colours
  std::string text = id.text();                        // name of the BRDF in options
  Brdf brdf;                                           // kLambert if there is no highlight

  bool has_highlight() const { return brdf.kind != BrdfKind::kLambert; }
  /// Returns whether the BRDF is shaded as a sum of vMFs.
  bool is_sum() const { return is_vmf_sum(brdf); }
  bool can_shade(Representation r) const { return !is_sum() || representation_info(r).takes_every_brdf; }
  /// Returns the BRDF's highlight, unless every bake measures it anyway.
  std::vector<Highlight> more_highlights() const;
};
/// Parses a BRDF with parse_brdf(), and uses only its highlight. Throws Error(kUsage) that names `option`, and
/// Error(kInput).
TargetBrdf parse_target_brdf(const std::string& text, const std::string& option = "--brdf");

/// The lowest error of `brdf` among the shading methods of a file. It includes colours if the file has colours.
struct ReachedError {
  double error = 0.0;
  double confidence = 0.0;  // half width of the 95 % interval
  double percentile_95 = 0.0;
  int worst_octave = 0;
  double worst_octave_error = 0.0;
  std::string shading;  // shading method for moments, such as "lean"; otherwise empty

  /// True if the error plus its interval is within `target`.
  bool meets(double target) const { return error + confidence <= target; }
};
ReachedError reached_error(const std::vector<FootprintError>& errors, const TargetBrdf& brdf);

/// Error and time of a candidate on the mosaic.
struct SettingTrial {
  std::size_t candidate;
  ReachedError reached;
  double seconds;        // time of fitting or averaging
  double fixed_seconds;  // time for the start and for coarse levels; it does not grow with the map
};

/// The trials of one map. Each trial is made only once, when it is requested for the first time.
class SettingTrials {
 public:
  /// `source` and `device` must outlive the object.
  SettingTrials(Device& device, const BakeJob& job, const BakeSource& source, TargetBrdf brdf,
                std::vector<SettingCandidate> candidates);

  const std::vector<SettingCandidate>& candidates() const { return candidates_; }
  const TargetBrdf& brdf() const { return brdf_; }
  /// The target's highlight, or none.
  const std::vector<Highlight>& highlights() const { return highlights_; }
  /// Makes the trial if needed. Throws Cancelled.
  const SettingTrial& at(std::size_t candidate, Progress* progress);
  /// Finished trials, in the order in which they were made.
  const std::vector<SettingTrial>& made() const { return made_; }
  /// Number of texels of the map per texel of the mosaic.
  double scale() const;

 private:
  Device& device_;
  const BakeJob job_;
  const TargetBrdf brdf_;
  const std::vector<Highlight> highlights_;  // highlight of the target, or none
  const BakeSource mosaic_;
  const std::vector<SettingCandidate> candidates_;
  std::vector<SettingTrial> made_;
  double scale_;
};

/// JOB with the settings of a candidate.
BakeJob with_candidate(const BakeJob& job, const SettingCandidate& candidate);

/// Returns the cheapest candidate, from index `first` on, that meets `error` on the mosaic, or nullopt. The candidate's
/// error plus interval, times `correction`, must be at most `error`. Skips a candidate if the error of its quicker
/// variant is too high, because a longer fit with the same number of lobes reduces the error by at most a quarter.
std::optional<SettingTrial> cheapest_within(SettingTrials& trials, double error, double correction, std::size_t first,
                                            Progress* progress);

}  // namespace multum
