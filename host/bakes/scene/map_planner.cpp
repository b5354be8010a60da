// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/map_planner.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr std::int64_t kTexelsASample = 65536;
// The largest allowed share of lobes that are too sharp for the storage. Every map has some such lobes
// (host/bakes/bake/movmf_file_bake.cpp).
constexpr double kUnrepresentableMax = 1.0 / 3.0;

std::string lobes_name(Representation representation, int lobes) {
  return fmt::format("{}, {} lobe{}", representation_info(representation).option, lobes, lobes == 1 ? "" : "s");
}

BakeCandidate finished(BakeCandidate candidate) {
  candidate.cost = bake_cost(candidate.shape);
  return candidate;
}

}  // namespace

/// A representation that is planned in addition to the lobes of the default bake, and its estimated error.
struct EstimatedRepresentation {
  Representation representation;
  double (*error)(LobeErrors& errors, const TexelCounts& counts, const std::vector<ShadedBy>& by, ColourModel colours);
};

namespace {

constexpr EstimatedRepresentation kOthers[] = {
    {Representation::kGmm, [](LobeErrors& errors, const TexelCounts& counts, const std::vector<ShadedBy>& by,
                              ColourModel colours) { return errors.gmm_error(counts.lobes, by, colours); }},
    {Representation::kMoments, [](LobeErrors& errors, const TexelCounts&, const std::vector<ShadedBy>& by,
                                  ColourModel colours) { return errors.lean_error(by, colours); }},
    {Representation::kSh, [](LobeErrors& errors, const TexelCounts& counts, const std::vector<ShadedBy>& by,
                             ColourModel colours) { return errors.sh_error(counts.sh_order, by, colours); }}};

}  // namespace

MapPlanner::MapPlanner(const SceneDescription& scene, std::size_t map, std::shared_ptr<BakeSource> source,
                       const PlanSettings& settings)
    : scene_(scene), map_(scene.maps[map]), source_(std::move(source)) {
  const PlaneStore& normals = source_->map.normals;
  plan_.name = map_.name;
  plan_.job = map_.job;
  plan_.width = normals.width();
  plan_.height = normals.height();
  plan_.level_count = mip_level_count(plan_.width, plan_.height);
  needs_ = needs_of(scene, map, plan_.width, plan_.level_count);
  check_weights();
  plan_.first_seen = needs_.first_seen;
  plan_.is_diffuse = needs_.diffuse;
  plan_.last_seen = needs_.last_seen;
  SurveySettings survey;
  survey.threads = settings.threads;
  // In small maps, fewer texels are surveyed, because a survey with many fits would take as long as the bake.
  survey.texels_per_level =
      std::clamp(static_cast<int>(std::int64_t{plan_.width} * plan_.height / kTexelsASample), 8, 32);
  const bool has_weights = needs_.weighted && source_->weights;
  survey_ = survey_map(normals, {source_->colours(), has_weights ? &*source_->weights : nullptr}, survey);
  plan_.z_min = survey_.z_min;
  errors_.emplace(survey_, LobeErrorSettings{std::max(1, std::min(needs_.first_seen, plan_.level_count - 1)),
                                             source_->has_roughness(), source_->mean_cosine, settings.threads});
}

MapPlan MapPlanner::plan() {
  has_colours_ = source_->albedo.has_value() && needs_.diffuse;
  const double range = survey_.normal_range * (needs_.specular ? std::sqrt(needs_.exponent_max) : 1.0);
  plan_.is_constant =
      range <= 0.5 * scene_.budget.estimate_margin && !needs_.width_in_map && !needs_.weighted && plan_.level_count > 1;
  add_default();
  const double target = scene_.budget.target_error.value_or(0.0), margin = scene_.budget.estimate_margin;
  plan_.limit = scene_.budget.target_error
                    ? PartErrors{target, target}
                    : PartErrors{plan_.default_bake.error.diffuse + margin, plan_.default_bake.error.specular + margin};
  if (plan_.is_constant) add_constant();
  else add_candidates();
  choose();
  source_.reset();  // the source is large
  return std::move(plan_);
}

void MapPlanner::check_weights() const {
  if (!needs_.weighted) return;
  for (const SceneObject& object : scene_.objects)
    if (&scene_.maps[object.map] == &map_ && object.materials.size() > 1 &&
        static_cast<int>(object.materials.size()) != source_->weights->count)
      throw Error(ErrorCode::kInput,
                  fmt::format("{}: holds {} weights, expected {}, one for each material of object \"{}\"",
                              map_.job.weights, source_->weights->count, object.materials.size(), object.name));
}

BakeShape MapPlanner::shape(Representation representation, int lobes) const {
  BakeShape s;
  s.width = plan_.width;
  s.height = plan_.height;
  s.representation = representation;
  s.lobe_count = lobes;
  s.encoding = representation_info(representation).encodings.front();
  s.first_level = plan_.is_constant ? plan_.level_count - 1 : plan_.first_seen;
  s.weight_count = source_->weights ? source_->weights->count : 0;
  s.exponent_count = needs_.width_in_map ? 1 : static_cast<int>(needs_.exponents().size());
  return s;
}

std::optional<double> MapPlanner::share_unrepresentable(int lobe_count) {
  const auto kept = static_cast<double>(storage_kappa_max(StorageEncoding::kSnorm16));
  if (needs_.width_in_map || needs_.exponent_max <= kept) return std::nullopt;
  return errors_->share_sharper(lobe_count, kept);
}

StorageEncoding MapPlanner::lobe_encoding(int lobes) {
  return share_unrepresentable(lobes).value_or(0.0) > kUnrepresentableMax ? StorageEncoding::kFloat
                                                                          : StorageEncoding::kSnorm16;
}

template <typename Error>
PartErrors MapPlanner::part_errors(const Error& error, ColourModel colours) const {
  PartErrors parts;
  if (needs_.diffuse) parts.diffuse = error(needs_.diffuse_by, has_colours_ ? colours : ColourModel::kNone);
  if (needs_.specular) parts.specular = error(needs_.highlights_by, ColourModel::kNone);
  return parts;
}

PartErrors MapPlanner::lobes_error(int lobes, ColourModel colours) {
  return part_errors([&](const std::vector<ShadedBy>& by, ColourModel c) { return errors_->error(lobes, by, c); },
                     colours);
}

// Adds the bake that `multum bake` makes by default.
void MapPlanner::add_default() {
  const int lobes = default_lobe_count();
  BakeShape s = shape(default_representation(), lobes);
  s.first_level = 0;
  s.has_colours = source_->albedo.has_value();
  s.exponent_count = 3;
  plan_.default_bake = finished({lobes_name(default_representation(), lobes), s, s.has_colours, {}, {}});
  if (plan_.is_constant) return;
  // If one lobe is within the margin, no comparison is needed, because the default bake's error is assumed not to be
  // higher.
  if (!scene_.budget.target_error) {
    const PartErrors one = lobes_error(1, ColourModel::kLobes);
    plan_.default_error_is_bound = one.worst() <= scene_.budget.estimate_margin;
    if (plan_.default_error_is_bound) plan_.default_bake.error = one;
  }
  if (!plan_.default_error_is_bound) plan_.default_bake.error = lobes_error(lobes, ColourModel::kLobes);
}

void MapPlanner::add_constant() {
  BakeShape s = shape(default_representation(), 1);
  const bool constant_colours = survey_.colour_range <= 0.5 * scene_.budget.estimate_margin;
  s.has_colours = has_colours_ && constant_colours;
  s.mean_colours = has_colours_ && !constant_colours;
  plan_.candidates = {finished({"vmf, 1 lobe, 1 texel",
                                s,
                                false,
                                {0.5 * scene_.budget.estimate_margin, 0.5 * scene_.budget.estimate_margin},
                                {}})};
}

void MapPlanner::add_lobes(int lobes) {
  BakeShape s = shape(default_representation(), lobes);
  s.encoding = lobe_encoding(lobes);
  const std::string name = lobes_name(default_representation(), lobes);
  if (has_colours_ && lobes > 1) {
    s.mean_colours = true;
    plan_.candidates.push_back(finished({name + ", 1 colour", s, false, lobes_error(lobes, ColourModel::kMean), {}}));
    s.mean_colours = false;
  }
  s.has_colours = has_colours_;
  plan_.candidates.push_back(
      finished({name, s, has_colours_ && lobes > 1, lobes_error(lobes, ColourModel::kLobes), {}}));
}

std::vector<SettingCandidate> MapPlanner::candidates_of(Representation representation) const {
  return setting_candidates(scene_.budget.target_error ? kSceneTarget : kScenePlan, representation);
}

void MapPlanner::add_candidates() {
  for (const SettingCandidate& one : candidates_of(default_representation())) {
    add_lobes(one.lobe_count());
    if (plan_.candidates.back().error.within(plan_.limit)) break;  // more lobes are not cheaper
  }
  if (plan_.default_error_is_bound) return;  // no other representation takes fewer textures
  // If the map has widths or weights, only lobes can be estimated. Sums of vMFs can be shaded only with lobes.
  if (needs_.width_in_map || needs_.weighted || needs_.takes_vmf) return;
  const BakeCandidate by_default = plan_.candidates.back();
  for (const EstimatedRepresentation& other : kOthers) add_other(other, by_default);
}

// Lobes of another family need as many textures and as much time to fit as the lobes of the default bake, so they are
// cheaper only if fewer lobes suffice. Representations by averages would show the highlight of an environment as one
// lobe around the mean normal.
void MapPlanner::add_other(const EstimatedRepresentation& other, const BakeCandidate& by_default) {
  const RepresentationInfo& info = representation_info(other.representation);
  const bool has_lobes = info.lobes != nullptr;
  if (has_lobes ? !info.takes_every_brdf && !scene_.environment.empty() : needs_.environment_highlight) return;
  const int most = by_default.shape.lobe_count - (by_default.error.within(plan_.limit) ? 1 : 0);
  for (const SettingCandidate& one : candidates_of(other.representation)) {
    BakeShape s = shape(other.representation, one.lobe_count());
    if (has_lobes && s.lobe_count > most) break;
    if (info.has_order) s.sh_order = one.sh_order();
    s.has_colours = has_colours_;
    const auto error = [&](const std::vector<ShadedBy>& by, ColourModel c) {
      return other.error(*errors_, {s.lobe_count, s.sh_order}, by, c);
    };
    plan_.candidates.push_back(finished({has_lobes        ? lobes_name(other.representation, s.lobe_count)
                                         : info.has_order ? fmt::format("{} of order {}", info.option, s.sh_order)
                                                          : info.option,
                                         s,
                                         has_lobes && has_colours_ && s.lobe_count > 1,
                                         part_errors(error, has_lobes ? ColourModel::kLobes : ColourModel::kMean),
                                         {}}));
    if (has_lobes && plan_.candidates.back().error.within(plan_.limit)) break;
  }
}

// The estimate is not a bound, so settings whose estimate is close to the target are tried
// (host/bakes/scene/scene_bake.cpp).
void MapPlanner::choose_nearest() {
  constexpr double kEstimateMargin = 1.5;
  const double target = *scene_.budget.target_error;
  const BakeCandidate* best = nullptr;
  for (const BakeCandidate& c : plan_.candidates)
    if (c.shape.representation == plan_.default_bake.shape.representation &&
        (!best || c.error.worst() < best->error.worst()))
      best = &c;
  if (best->error.worst() > kEstimateMargin * target)
    throw Error(
        ErrorCode::kVerification,
        fmt::format("{}: no settings have an estimated error close to target_error {:g}; the lowest is {:.3g} ({})",
                    map_.job.input, target, best->error.worst(), best->name));
  plan_.chosen = *best;
}

void MapPlanner::choose() {
  const auto textures = [](const BakeCandidate& c) { return texture_count(c.shape) + (c.shape.mean_colours ? 1 : 0); };
  std::stable_sort(plan_.candidates.begin(), plan_.candidates.end(),
                   [&](const BakeCandidate& a, const BakeCandidate& b) {
                     return std::pair(textures(a), a.cost.ms) < std::pair(textures(b), b.cost.ms);
                   });
  const auto found = std::find_if(plan_.candidates.begin(), plan_.candidates.end(),
                                  [&](const BakeCandidate& c) { return c.error.within(plan_.limit); });
  if (found == plan_.candidates.end()) choose_nearest();
  else plan_.chosen = *found;
}

}  // namespace multum
