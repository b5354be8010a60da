// SPDX-License-Identifier: Apache-2.0
// Plans one map. Lists the ways to bake it that a scene allows, estimates their errors, and chooses one.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/bakes/scene/lobe_errors.h"
#include "host/bakes/scene/map_needs.h"
#include "host/bakes/scene/map_survey.h"
#include "host/bakes/scene/scene_plan.h"
#include "host/bakes/settings_search/setting_candidates.h"

namespace multum {

struct EstimatedRepresentation;

class MapPlanner {
 public:
  /// Surveys scene.maps[map], which has been read into `source`. `scene` must outlive the object. Throws Error(kInput)
  /// if the map does not have a weight for each material.
  MapPlanner(const SceneDescription& scene, std::size_t map, std::shared_ptr<BakeSource> source,
             const PlanSettings& settings);

  /// Chooses the cheapest candidate within the limit. The result includes neither the rows of the table nor the job's
  /// settings. Call this function once. If no candidate is expected to reach the target error, chooses the candidate
  /// with the lowest error. Throws Error(kVerification) if that error is far above the target.
  MapPlan plan();

  const MapNeeds& needs() const { return needs_; }
  const MapSurvey& survey() const { return survey_; }
  LobeErrors& errors() { return *errors_; }
  /// Returns the share of lobes that are too sharp for 16 bits, or nullopt if no visible material needs this share.
  std::optional<double> share_unrepresentable(int lobe_count);

 private:
  void check_weights() const;
  BakeShape shape(Representation representation, int lobes) const;
  StorageEncoding lobe_encoding(int lobes);
  template <typename Error>
  PartErrors part_errors(const Error& error, ColourModel colours) const;
  PartErrors lobes_error(int lobes, ColourModel colours);
  void add_default();
  void add_constant();
  void add_lobes(int lobes);
  std::vector<SettingCandidate> candidates_of(Representation representation) const;
  void add_candidates();
  void add_other(const EstimatedRepresentation& other, const BakeCandidate& by_default);
  void choose_nearest();
  void choose();

  const SceneDescription& scene_;
  const SceneMap& map_;
  std::shared_ptr<BakeSource> source_;
  MapPlan plan_;
  MapNeeds needs_;
  MapSurvey survey_;
  std::optional<LobeErrors> errors_;
  bool has_colours_ = false;
};

}  // namespace multum
