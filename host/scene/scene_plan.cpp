// SPDX-License-Identifier: Apache-2.0
#include "host/scene/scene_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numbers>

#include "host/base/error.h"
#include "host/brdf/facet_distribution.h"
#include "host/brdf/fresnel.h"
#include "host/scene/lobe_errors.h"
#include "host/scene/scene_difference.h"
#include "host/scene/seen_levels.h"

namespace multum {
namespace {

// Highlights broader than this are followed by harmonics of order 8, as multum-view evaluates them in an environment:
// what Blinn-Phong of s = 12 has beyond is 8 % (docs/ALGORITHMS.md, "Environments").
constexpr double kHarmonicsExponentMax = 12.0;
constexpr std::int64_t kTexelsASample = 65536;
constexpr int kLobesUsual = 4, kLobesMax = 8;
// Lobes as sharp as the storage loses, as a share: fewer are in every map (host/bake/movmf_file_bake.cpp).
constexpr double kBeyondStorageMax = 1.0 / 3.0;

std::string percent(double share) {
  return share < 0.995 ? fmt::format("{:.2g} %", 100.0 * share) : fmt::format("{:.0f} %", 100.0 * share);
}

// What an object's materials ask of a map, together with all others that show it.
struct MapNeeds {
  bool diffuse = false, specular = false;
  bool width_in_map = false, weighted = false;
  bool environment_highlight = false, takes_vmf = false;  // GGX and what was measured are sums of vMFs
  double exponent_min = 0.0, exponent_max = 0.0;          // of highlights that have one
  int first_seen = 0, last_seen = 0;
  std::vector<ShadedBy> diffuse_by, highlights_by;

  void add_diffuse(int weight) {
    diffuse = true;
    add(diffuse_by, {std::nullopt, weight});
  }
  void add_highlight(double exponent, int weight) {
    specular = true;
    add(highlights_by, {exponent, weight});
    if (!std::isfinite(exponent)) return;
    const bool is_first = exponent_max == 0.0;
    exponent_min = is_first ? exponent : std::min(exponent_min, exponent);
    exponent_max = is_first ? exponent : std::max(exponent_max, exponent);
  }
  // The sharpest and the broadest: what is measured of a bake. None where widths are the map's.
  std::vector<double> exponents() const {
    std::vector<double> ends;
    if (exponent_max > 0.0) ends.push_back(exponent_max);
    if (exponent_min < exponent_max) ends.push_back(exponent_min);
    return ends;
  }

 private:
  static void add(std::vector<ShadedBy>& all, const ShadedBy& one) {
    const auto is_one = [&](const ShadedBy& by) { return by.exponent == one.exponent && by.weight == one.weight; };
    if (std::none_of(all.begin(), all.end(), is_one)) all.push_back(one);
  }
};

bool is_black(const glm::vec3& colour) { return colour == glm::vec3(0.0f); }

// `weight`: of the map's, that it is blended by; -1: none.
void add_material(const Scene& scene, const SceneMaterial& material, int weight, MapNeeds& needs) {
  needs.width_in_map |= material.width_in_map;
  for (const Brdf& brdf : material.brdfs) {
    if (!is_black(brdf.diffuse)) needs.add_diffuse(weight);
    if (!has_highlight(brdf)) continue;
    needs.add_highlight(material.width_in_map ? std::numeric_limits<double>::infinity() : equivalent_exponent(brdf),
                        weight);
    needs.environment_highlight |= !scene.environment.empty();
    needs.takes_vmf |= brdf.kind == BrdfKind::kGgx || brdf.kind == BrdfKind::kMeasured;
  }
}

MapNeeds needs_of(const Scene& scene, std::size_t map, int width, int level_count) {
  MapNeeds needs;
  bool is_first = true;
  for (const SceneObject& object : scene.objects) {
    if (object.map != map) continue;
    const SeenLevels seen = seen_levels(scene.camera, object, width, level_count);
    needs.first_seen = is_first ? seen.first : std::min(needs.first_seen, seen.first);
    needs.last_seen = is_first ? seen.last : std::max(needs.last_seen, seen.last);
    is_first = false;
    needs.weighted |= object.materials.size() > 1;
    for (std::size_t k = 0; k < object.materials.size(); ++k)
      add_material(scene, scene.materials[object.materials[k]], object.materials.size() > 1 ? static_cast<int>(k) : -1,
                   needs);
  }
  return needs;
}

// One map's candidates and their errors.
class MapPlanner {
 public:
  MapPlanner(const Scene& scene, std::size_t map, std::shared_ptr<BakeSource> source, const PlanSettings& settings)
      : scene_(scene), map_(scene.maps[map]), source_(std::move(source)) {
    const PlaneStore& normals = source_->map.normals;
    plan_.name = map_.name;
    plan_.job = map_.job;
    plan_.width = normals.width();
    plan_.height = normals.height();
    plan_.level_count = mip_level_count(plan_.width, plan_.height);
    needs_ = needs_of(scene, map, plan_.width, plan_.level_count);
    plan_.first_seen = needs_.first_seen;
    plan_.is_diffuse = needs_.diffuse;
    plan_.last_seen = needs_.last_seen;
    SurveySettings survey;
    survey.threads = settings.threads;
    // Bakes of small maps take no longer than many fits.
    survey.texels_per_level =
        std::clamp(static_cast<int>(std::int64_t{plan_.width} * plan_.height / kTexelsASample), 8, 32);
    survey_ = survey_map(normals, {source_->colours(), needs_.weighted ? source_->weight_map() : nullptr}, survey);
    plan_.z_min = survey_.z_min;
    errors_.emplace(survey_, LobeErrorSettings{std::max(1, std::min(needs_.first_seen, plan_.level_count - 1)),
                                               source_->has_roughness, source_->mean_cosine, settings.threads});
  }

  MapPlan plan() {
    has_colours_ = source_->albedo.has_value() && needs_.diffuse;
    const double range = survey_.normal_range * (needs_.specular ? std::sqrt(needs_.exponent_max) : 1.0);
    plan_.is_constant =
        range <= 0.5 * scene_.budget.tolerance && !needs_.width_in_map && !needs_.weighted && plan_.level_count > 1;
    add_usual();
    const double target = scene_.budget.target_error.value_or(0.0), tolerance = scene_.budget.tolerance;
    plan_.limit = scene_.budget.target_error
                      ? PartErrors{target, target}
                      : PartErrors{plan_.usual.error.diffuse + tolerance, plan_.usual.error.specular + tolerance};
    if (plan_.is_constant) add_constant();
    else add_candidates();
    choose();
    source_.reset();  // large
    return std::move(plan_);
  }

  const MapNeeds& needs() const { return needs_; }
  const MapSurvey& survey() const { return survey_; }
  LobeErrors& errors() { return *errors_; }

 private:
  BakeShape shape(Representation representation, int lobes) const {
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

  static BakeCandidate finished(BakeCandidate candidate) {
    candidate.cost = bake_cost(candidate.shape);
    return candidate;
  }

  template <typename Error>
  PartErrors part_errors(const Error& error, ColourModel colours) const {
    PartErrors parts;
    if (needs_.diffuse) parts.diffuse = error(needs_.diffuse_by, has_colours_ ? colours : ColourModel::kNone);
    if (needs_.specular) parts.specular = error(needs_.highlights_by, ColourModel::kNone);
    return parts;
  }
  PartErrors lobes_error(int lobes, ColourModel colours) {
    return part_errors([&](const std::vector<ShadedBy>& by, ColourModel c) { return errors_->error(lobes, by, c); },
                       colours);
  }

  // What `multum bake` does of itself.
  void add_usual() {
    BakeShape s = shape(Representation::kMovmf, kLobesUsual);
    s.first_level = 0;
    s.has_colours = source_->albedo.has_value();
    s.exponent_count = 3;
    plan_.usual = finished({"vmf, 4 lobes", s, s.has_colours, {}, {}});
    if (plan_.is_constant) return;
    // One lobe within the tolerance needs no comparison: the default bake is taken to be no worse.
    if (!scene_.budget.target_error) {
      const PartErrors one = lobes_error(1, ColourModel::kLobes);
      one_lobe_is_enough_ = one.worst() <= scene_.budget.tolerance;
      if (one_lobe_is_enough_) plan_.usual.error = one;
    }
    if (!one_lobe_is_enough_) plan_.usual.error = lobes_error(kLobesUsual, ColourModel::kLobes);
  }

  void add_constant() {
    BakeShape s = shape(Representation::kMovmf, 1);
    const bool constant_colours = survey_.colour_range <= 0.5 * scene_.budget.tolerance;
    s.has_colours = has_colours_ && constant_colours;
    s.mean_colours = has_colours_ && !constant_colours;
    plan_.candidates = {finished(
        {"vmf, 1 lobe, 1 texel", s, false, {0.5 * scene_.budget.tolerance, 0.5 * scene_.budget.tolerance}, {}})};
  }

  void add_lobes(int lobes) {
    BakeShape s = shape(Representation::kMovmf, lobes);
    const std::string name = fmt::format("vmf, {} lobe{}", lobes, lobes == 1 ? "" : "s");
    if (has_colours_ && lobes > 1) {
      s.mean_colours = true;
      plan_.candidates.push_back(finished({name + ", 1 colour", s, false, lobes_error(lobes, ColourModel::kMean), {}}));
      s.mean_colours = false;
    }
    s.has_colours = has_colours_;
    plan_.candidates.push_back(
        finished({name, s, has_colours_ && lobes > 1, lobes_error(lobes, ColourModel::kLobes), {}}));
  }

  void add_candidates() {
    const int most = scene_.budget.target_error ? kLobesMax : kLobesUsual;
    for (int lobes = 1; lobes <= most; ++lobes) {
      add_lobes(lobes);
      if (plan_.candidates.back().error.within(plan_.limit)) break;  // more lobes are no cheaper
    }
    if (one_lobe_is_enough_) return;  // no other takes fewer textures
    // Of widths in the map and of weights, only lobes are estimated.
    if (needs_.width_in_map || needs_.weighted) return;
    add_gaussians();
    // Of harmonics and moments an environment's highlight is that of one lobe of the mean normal.
    if (needs_.environment_highlight) return;
    BakeShape s = shape(Representation::kMoments, 1);
    s.has_colours = has_colours_;
    const auto lean = [&](const std::vector<ShadedBy>& by, ColourModel c) { return errors_->lean_error(by, c); };
    plan_.candidates.push_back(finished({"moments", s, false, part_errors(lean, ColourModel::kMean), {}}));
    for (const int order : {2, 4}) {
      s = shape(Representation::kSh, 1);
      s.sh_order = order;
      s.has_colours = has_colours_;
      const auto sh = [&](const std::vector<ShadedBy>& by, ColourModel c) { return errors_->sh_error(order, by, c); };
      plan_.candidates.push_back(
          finished({fmt::format("sh of order {}", order), s, false, part_errors(sh, ColourModel::kMean), {}}));
    }
  }

  // Gaussians take as many textures as vMFs, and as much time to fit: they are cheaper where fewer will do.
  void add_gaussians() {
    if (needs_.takes_vmf || !scene_.environment.empty()) return;
    const BakeCandidate vmf = plan_.candidates.back();
    const int most = vmf.shape.lobe_count - (vmf.error.within(plan_.limit) ? 1 : 0);
    for (int lobes = 1; lobes <= most; ++lobes) {
      BakeShape s = shape(Representation::kGmm, lobes);
      s.has_colours = has_colours_;
      const auto gmm = [&](const std::vector<ShadedBy>& by, ColourModel c) { return errors_->gmm_error(lobes, by, c); };
      plan_.candidates.push_back(finished({fmt::format("gmm, {} lobe{}", lobes, lobes == 1 ? "" : "s"),
                                           s,
                                           has_colours_ && lobes > 1,
                                           part_errors(gmm, ColourModel::kLobes),
                                           {}}));
      if (plan_.candidates.back().error.within(plan_.limit)) break;
    }
  }

  void choose() {
    const auto textures = [](const BakeCandidate& c) {
      return texture_count(c.shape) + (c.shape.mean_colours ? 1 : 0);
    };
    std::stable_sort(plan_.candidates.begin(), plan_.candidates.end(),
                     [&](const BakeCandidate& a, const BakeCandidate& b) {
                       return std::pair(textures(a), a.cost.ms) < std::pair(textures(b), b.cost.ms);
                     });
    const auto found = std::find_if(plan_.candidates.begin(), plan_.candidates.end(),
                                    [&](const BakeCandidate& c) { return c.error.within(plan_.limit); });
    if (found == plan_.candidates.end()) {
      const auto best =
          std::min_element(plan_.candidates.begin(), plan_.candidates.end(),
                           [](const auto& a, const auto& b) { return a.error.worst() < b.error.worst(); });
      throw Error(ErrorCode::kVerification,
                  fmt::format("{}: no settings are estimated to reach target_error {:g}, the best is {:.3g} ({})",
                              map_.job.input, *scene_.budget.target_error, best->error.worst(), best->name));
    }
    plan_.chosen = *found;
  }

  const Scene& scene_;
  const SceneMap& map_;
  std::shared_ptr<BakeSource> source_;
  MapPlan plan_;
  MapNeeds needs_;
  MapSurvey survey_;
  std::optional<LobeErrors> errors_;
  bool has_colours_ = false;
  bool one_lobe_is_enough_ = false;
};

// The rows of a map's table.
class EffectRows {
 public:
  EffectRows(const Scene& scene, MapPlanner& planner, MapPlan& plan)
      : scene_(scene), planner_(planner), plan_(plan), needs_(planner.needs()), chosen_(plan.chosen.shape) {}

  void add() {
    add_filtering();
    add_lobes();
    add_other_representations();
    add_anisotropy();
    add_levels();
    add_colours();
    add_precision();
    add_materials();
    add_measurement();
  }

 private:
  bool is_estimated() const { return !plan_.is_constant; }
  void add_row(const std::string& effect, bool needed, const std::string& why) {
    plan_.effects.push_back({effect, needed, why, false, {}});
  }
  void add_row(const std::string& effect, bool needed, const std::string& why, const BakeCost& cost) {
    plan_.effects.push_back({effect, needed, why, true, cost});
  }
  // "1.2 %", "1.2/14 %" of diffuse light and highlights.
  std::string parts_text(const PartErrors& e) const {
    return !needs_.specular  ? percent(e.diffuse)
           : !needs_.diffuse ? percent(e.specular)
                             : fmt::format("{:.2g}/{:.2g} %", 100.0 * e.diffuse, 100.0 * e.specular);
  }
  const char* parts_name() const {
    return !needs_.specular ? "diffuse light is" : !needs_.diffuse ? "highlights are" : "diffuse light/highlights are";
  }
  // Of the default bake with a change.
  template <typename Change>
  BakeCost usual_with(const Change& change) const {
    BakeShape s = plan_.usual.shape;
    change(s);
    return bake_cost(s);
  }
  BakeCost saved_by(const std::function<void(BakeShape&)>& change) const {
    return plan_.usual.cost - usual_with(change);
  }
  BakeCost chosen_without(const std::function<void(BakeShape&)>& change) const {
    BakeShape s = chosen_;
    change(s);
    return plan_.chosen.cost - bake_cost(s);
  }

  std::string seen_texels() const {
    return plan_.first_seen > 0 ? fmt::format("from level {} on", plan_.first_seen) : "from level 1 on";
  }

  void add_filtering() {
    if (plan_.is_constant) {
      add_row("normals under texels", false,
              fmt::format("all normals are within {:.2g} of one another: one texel stands for all",
                          planner_.survey().normal_range),
              plan_.usual.cost - plan_.chosen.cost);
      return;
    }
    double spread = 0.0;
    for (const LevelStatistics& level : planner_.survey().levels)
      if (level.level >= plan_.first_seen) spread = std::max(spread, level.spread_mean);
    if (needs_.width_in_map) {
      add_row("normals under texels", true, fmt::format("spread of normals and of their BRDFs up to {:.2g}", spread));
      return;
    }
    const double without = error_of(0);
    const bool needed = without > scene_.budget.tolerance;
    add_row(
        "normals under texels", needed,
        fmt::format("spread of normals up to {:.2g}; one mean direction a texel is {} off", spread, percent(without)));
  }

  double error_of(int lobes) {
    double worst = needs_.diffuse ? planner_.errors().error(lobes, needs_.diffuse_by, ColourModel::kNone) : 0.0;
    if (needs_.specular)
      worst = std::max(worst, planner_.errors().error(lobes, needs_.highlights_by, ColourModel::kNone));
    return worst;
  }

  void add_lobes() {
    const bool needed = holds_lobes(chosen_.representation) && chosen_.lobe_count > 1;
    const auto one = [](BakeShape& s) { s.lobe_count = 1; };
    if (!is_estimated()) {
      add_row("several lobes, EM", false, "nothing to share out", saved_by(one));
      return;
    }
    std::string tried;
    for (const BakeCandidate& c : plan_.candidates)
      if (c.shape.representation == Representation::kMovmf)
        tried += fmt::format("{}{} {}", tried.empty() ? "" : ", ", c.name.substr(5), parts_text(c.error));
    add_row(
        "several lobes, EM", needed,
        fmt::format("{} off {}: {}; {}", parts_name(), seen_texels(), tried,
                    plan_.candidates.size() == 1 ? fmt::format("tolerance {}", percent(scene_.budget.tolerance))
                                                 : fmt::format("the default's 4 {}; limit {}",
                                                               parts_text(plan_.usual.error), parts_text(plan_.limit))),
        needed ? chosen_without(one) : saved_by(one));
    if (needed) add_row("aligned lobes", true, "several lobes are filtered by hardware, each with its like");
  }

  // Why there is no candidate of it.
  std::string why_not_tried(Representation representation) const {
    if (plan_.is_constant) return "one lobe stands for all";
    if (needs_.width_in_map || needs_.weighted) return "widths in the map and weights take vMF lobes";
    if (representation == Representation::kGmm && needs_.takes_vmf) return "GGX and measured BRDFs take vMF lobes";
    if (needs_.environment_highlight || representation == Representation::kGmm)
      return !scene_.environment.empty() ? "an environment takes vMF lobes" : "one vMF lobe does";
    return "one or several lobes do";
  }

  void add_other_representations() {
    for (const auto& [representation, effect] : {std::pair{Representation::kGmm, "planar Gaussians"},
                                                 std::pair{Representation::kMoments, "moments of slopes (LEAN)"},
                                                 std::pair{Representation::kSh, "spherical harmonics"}}) {
      const bool needed = chosen_.representation == representation;
      std::string tried;
      for (const BakeCandidate& c : plan_.candidates)
        if (c.shape.representation == representation)
          tried += fmt::format("{}{} {}, {} texture{}", tried.empty() ? "" : "; ", c.name, parts_text(c.error),
                               texture_count(c.shape), texture_count(c.shape) == 1 ? "" : "s");
      add_row(effect, needed, tried.empty() ? why_not_tried(representation) : "off " + tried);
    }
  }

  void add_anisotropy() {
    double anisotropy = 0.0;
    int at = 0;
    for (const LevelStatistics& level : planner_.survey().levels)
      if (level.level >= plan_.first_seen && level.anisotropy > anisotropy) {
        anisotropy = level.anisotropy;
        at = level.level;
      }
    const bool needed =
        chosen_.representation == Representation::kMoments || (anisotropy > 0.5 && chosen_.lobe_count > 1);
    add_row("anisotropic spread", needed,
            plan_.is_constant
                ? "there is no spread"
                : fmt::format("{:.2f} of 1, most at level {}{}", anisotropy, at,
                              needed && chosen_.lobe_count > 1 ? ": round lobes side by side stand for it" : ""));
  }

  void add_levels() {
    const bool fine = chosen_.first_level == 0;
    const std::string why = plan_.is_constant ? "all texels of all levels are alike"
                                              : fmt::format("seen are levels {} to {} of 0 to {}", plan_.first_seen,
                                                            plan_.last_seen, plan_.level_count - 1);
    if (fine) {
      add_row("finest levels", true, why, chosen_without([](BakeShape& s) { s.first_level = 1; }));
    } else {
      const int first = chosen_.first_level;
      add_row("finest levels", false, why + fmt::format(": stored from {} on", first),
              saved_by([&](BakeShape& s) { s.first_level = first; }));
    }
    if (plan_.is_constant) return;
    const double last = static_cast<double>(mip_level_size(plan_.width, plan_.last_seen)) *
                        mip_level_size(plan_.height, plan_.last_seen);
    add_row("coarsest levels", plan_.last_seen >= plan_.level_count - 1,
            fmt::format("{}: kept all the same, finer ones grow from them, and all beyond are {:.0f} texels", why,
                        last / 3.0));
  }

  void add_colours() {
    if (plan_.job.albedo.empty()) {
      add_row("colours", false, "the map has no albedo");
      return;
    }
    const auto none = [](BakeShape& s) { s.has_colours = false; };
    if (!needs_.diffuse) {
      add_row("colours", false, "no material reflects diffusely", saved_by(none));
      return;
    }
    add_row("colours", true, "the map has an albedo",
            chosen_without([&](BakeShape& s) { s.has_colours = s.mean_colours = false; }));
    if (!is_estimated()) return;
    const int lobes = std::max(chosen_.lobe_count, 2);
    const double correlation = planner_.errors().colour_correlation(lobes);
    const auto error = [&](ColourModel model) { return planner_.errors().error(lobes, needs_.diffuse_by, model); };
    add_row("colours of each lobe", plan_.chosen.lobe_colours,
            fmt::format("{} of the colours' variance lies between {} lobes; diffuse light is {} off with one colour a "
                        "texel, {} with one a lobe",
                        percent(correlation), lobes, percent(error(ColourModel::kMean)),
                        percent(error(ColourModel::kLobes))),
            plan_.chosen.lobe_colours ? chosen_without(none) : saved_by([&](BakeShape& s) {
              s.has_colours = false;
              s.mean_colours = true;
            }));
  }

  void add_precision() {
    if (chosen_.representation != Representation::kMovmf) return;
    const auto kept = static_cast<double>(storage_kappa_max(StorageEncoding::kSnorm16));
    if (!is_estimated() || needs_.width_in_map || needs_.exponent_max <= kept) {
      add_row("32-bit storage", false,
              needs_.width_in_map ? "highlights are as broad as the roughness says"
              : needs_.specular   ? fmt::format("highlights up to s = {:.0f}, 16 bits keep lobes up to kappa {:.0f}",
                                                needs_.exponent_max, kept)
                                  : "no highlights");
      return;
    }
    const double share = planner_.errors().share_sharper(chosen_.lobe_count, kept);
    const bool needed = share > kBeyondStorageMax;
    add_row("32-bit storage", needed,
            fmt::format("{} of the lobes are sharper than 16 bits keep (kappa {:.0f}), highlights up to s = {:.0f}",
                        percent(share), kept, needs_.exponent_max));
    if (!needed) return;
    const BakeCost before = plan_.chosen.cost;
    plan_.chosen.shape.encoding = StorageEncoding::kFloat;
    plan_.chosen.cost = bake_cost(plan_.chosen.shape);
    plan_.effects.back().has_cost = true;
    plan_.effects.back().cost = plan_.chosen.cost - before;
  }

  void add_materials() {
    add_row("roughness in normals", needs_.width_in_map,
            needs_.width_in_map ? "the map has a roughness" : "the map has no roughness");
    add_row("weights of BRDFs", needs_.weighted,
            needs_.weighted              ? "an object blends several materials"
            : !plan_.job.weights.empty() ? "no object blends several materials"
                                         : "the map has no weights");
  }

  void add_measurement() {
    const auto count = needs_.exponents().size();
    const auto none = [](BakeShape& s) { s.exponent_count = 0; };
    const bool needed = count > 0 || needs_.width_in_map;
    add_row("measuring highlights", needed,
            needs_.width_in_map ? "as wide as the roughness says"
            : needed            ? fmt::format("at s = {:.4g}{}", needs_.exponent_max,
                                   count > 1 ? fmt::format(" and {:.4g}", needs_.exponent_min) : "")
                                : "there are none",
            needed ? chosen_without(none) : saved_by(none));
  }

  const Scene& scene_;
  MapPlanner& planner_;
  MapPlan& plan_;
  const MapNeeds& needs_;
  const BakeShape& chosen_;
};

// The bake that a plan asks for.
void fill_job(const MapNeeds& needs, const SceneBudget& budget, MapPlan& plan) {
  const BakeShape& s = plan.chosen.shape;
  BakeJob& job = plan.job;
  job.representation = s.representation;
  job.sh_order = s.sh_order;
  job.fitting.lobe_count = s.lobe_count;
  job.fitting.first_level = s.first_level;
  job.encoding = s.encoding;
  plan.mean_colours = s.mean_colours;
  if (s.mean_colours) plan.colour_file = job.albedo;
  if (!s.has_colours) job.albedo.clear();
  if (!needs.weighted) job.weights.clear();
  if (plan.source && job.albedo.empty()) plan.source->albedo.reset();
  if (plan.source && job.weights.empty()) plan.source->weights.reset();
  job.measured_exponents = needs.exponents();
  const bool as_usual =
      !budget.target_error && plan.chosen.name == plan.usual.name && s.encoding == plan.usual.shape.encoding;
  if (plan.is_constant) job.measure = false;  // how far normals are apart is known
  plan.stated_difference =
      as_usual && !plan.is_constant ? 0.0 : plan.chosen.error.worst() + plan.usual.error.worst() + budget.tolerance;
}

// Down to the scene's budgets, each time the step that adds the least error.
void hold_to_budgets(const SceneBudget& budget, std::vector<MapPlan>& maps) {
  for (const auto& [limit, what, value] :
       {std::tuple{budget.bytes, "bytes", &BakeCost::bytes}, std::tuple{budget.bake_ms, "bake_ms", &BakeCost::ms}}) {
    if (!limit) continue;
    for (;;) {
      double total = 0.0;
      for (const MapPlan& map : maps) total += map.chosen.cost.*value;
      if (total <= *limit) break;
      MapPlan* cheapest = nullptr;
      const BakeCandidate* step = nullptr;
      for (MapPlan& map : maps)
        for (const BakeCandidate& c : map.candidates)
          if (c.cost.*value < map.chosen.cost.*value && (step == nullptr || c.error.worst() < step->error.worst())) {
            cheapest = &map;
            step = &c;
          }
      if (step == nullptr)
        throw Error(
            ErrorCode::kVerification,
            fmt::format("no settings keep to the budget's {} of {:.0f}: the least is {:.0f}", what, *limit, total));
      cheapest->chosen = *step;
    }
  }
}

void add_row(ObjectPlan& object, const std::string& effect, bool needed, const std::string& why) {
  object.effects.push_back({effect, needed, why, false, {}});
}

// How near to 0 v.h comes: half the angle between the line of sight, within `tilt` of the surface, and light that
// reaches the steepest normal from its horizon.
double least_half_cosine(double tilt_degrees, double z_min) {
  const double steepest = std::acos(std::clamp(z_min, 0.0, 1.0));
  const double between = tilt_degrees * std::numbers::pi / 180.0 + 0.5 * std::numbers::pi + steepest;
  return std::cos(0.5 * std::min(between, std::numbers::pi));
}

void add_fresnel(const Scene& scene, const SceneObject& object, const MapPlan& map, ObjectPlan& plan) {
  const auto brdf_of = [&](std::size_t m) -> const Brdf& { return scene.materials[m].brdfs.front(); };
  const bool has_any = std::any_of(object.materials.begin(), object.materials.end(),
                                   [&](std::size_t m) { return has_fresnel(brdf_of(m)); });
  if (!has_any) return add_row(plan, "Fresnel", false, "the BRDF has none");
  if (!scene.environment.empty()) return add_row(plan, "Fresnel", true, "an environment's light comes from everywhere");
  if (object.materials.size() > 1) return add_row(plan, "Fresnel", true, "one of several BRDFs has one");
  const double v_h = least_half_cosine(object.tilt_max, map.z_min), tolerance = scene.budget.tolerance;
  const FixedFresnel fixed = fixed_fresnel(brdf_of(object.materials.front()), v_h);
  const bool needed = fixed.change > tolerance;
  const std::string bound = fmt::format(
      "v.h is at least {:.2f} (tilt {:g} degrees, normals up to {:.0f}): a number in "
      "its place is at most {} off, tolerance {}",
      v_h, object.tilt_max, std::acos(std::clamp(map.z_min, 0.0, 1.0)) * 180.0 / std::numbers::pi,
      percent(fixed.change), percent(tolerance));
  add_row(plan, "Fresnel", needed, bound);
  if (needed) return;
  plan.fixed_fresnel = fixed.value;
  plan.stated_difference += fixed.change;
}

// What an object's shader holds.
ObjectPlan plan_object(const Scene& scene, const SceneObject& object, const MapPlan& map) {
  ObjectPlan plan;
  plan.name = object.name;
  plan.map = object.map;
  const SeenLevels seen = seen_levels(scene.camera, object, map.width, map.level_count);
  plan.first_level = seen.first;
  plan.last_level = seen.last;
  bool highlight = false, dynamic = false;
  double exponent = 0.0;
  for (const std::size_t m : object.materials) {
    const SceneMaterial& material = scene.materials[m];
    dynamic |= material.is_dynamic();
    for (const Brdf& brdf : material.brdfs) {
      highlight |= has_highlight(brdf);
      if (has_highlight(brdf)) exponent = std::max(exponent, equivalent_exponent(brdf));
    }
  }
  const bool environment = !scene.environment.empty();
  plan.environment_by_harmonics = environment && highlight && exponent <= kHarmonicsExponentMax;
  add_row(plan, "highlight", highlight,
          highlight ? fmt::format("as sharp as Blinn-Phong of s = {:.4g}", exponent) : "the material is diffuse");
  plan.stated_difference = map.stated_difference;
  add_fresnel(scene, object, map, plan);
  add_row(plan, "width as a uniform", dynamic, dynamic ? "the material changes at run time" : "the material is fixed");
  const auto points = std::count_if(scene.lights.begin(), scene.lights.end(), [](const auto& l) { return l.is_point; });
  const auto distant = static_cast<std::ptrdiff_t>(scene.lights.size()) - points;
  add_row(plan, "distant lights", distant > 0, fmt::format("the scene has {}", distant));
  add_row(plan, "point lights", points > 0, fmt::format("the scene has {}", points));
  add_row(plan, "environment, diffuse", environment,
          environment ? "harmonics to order 2 hold all but 1 % of it" : "the scene has none");
  add_row(plan, "environment, highlight", environment && highlight,
          !environment ? "the scene has none"
          : !highlight ? "the material has no highlight"
          : plan.environment_by_harmonics
              ? "harmonics to order 8: the highlight is broad"
              : fmt::format("prefiltered mips: order 8 ends at s = {:.0f}", kHarmonicsExponentMax));
  return plan;
}

}  // namespace

ScenePlan plan_scene(const Scene& scene, const PlanSettings& settings, Progress* progress) {
  const auto start = std::chrono::steady_clock::now();
  ScenePlan plan;
  std::vector<std::unique_ptr<MapPlanner>> planners;
  std::uint64_t kept = 0;
  for (std::size_t m = 0; m < scene.maps.size(); ++m) {
    progress_stage(progress, "plan");
    BakeJob job = scene.maps[m].job;
    job.threads = settings.threads;
    if (job.scratch_folder.empty()) job.scratch_folder = std::filesystem::temp_directory_path().string();
    BakeReport read;  // what the maps say of themselves is told by the bake, too
    auto source = std::make_shared<BakeSource>(read_source(job, read, progress));
    planners.push_back(std::make_unique<MapPlanner>(scene, m, source, settings));
    plan.maps.push_back(planners.back()->plan());
    MapPlan& map = plan.maps.back();
    if (settings.for_bake && !map.is_constant)
      map.mosaics = std::make_shared<std::vector<BakeSource>>(difference_mosaics(*source));
    const std::uint64_t bytes =
        static_cast<std::uint64_t>(map.width) * static_cast<std::uint64_t>(map.height) * 12 * (source->albedo ? 2 : 1);
    if (kept + bytes <= settings.kept_bytes_max) {
      map.source = source;
      kept += bytes;
    }
  }
  hold_to_budgets(scene.budget, plan.maps);
  for (std::size_t m = 0; m < plan.maps.size(); ++m) {
    MapPlan& map = plan.maps[m];
    EffectRows(scene, *planners[m], map).add();
    fill_job(planners[m]->needs(), scene.budget, map);
    plan.cost += map.chosen.cost;
    plan.usual_cost += map.usual.cost;
  }
  for (const SceneObject& object : scene.objects)
    plan.objects.push_back(plan_object(scene, object, plan.maps[object.map]));
  plan.plan_seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return plan;
}

}  // namespace multum
