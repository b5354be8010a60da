// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/effect_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <map>

#include "host/bakes/scene/plan_text.h"

namespace multum {
namespace {

std::string count_text(int count, const char* what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

class EffectRows {
 public:
  EffectRows(const SceneDescription& scene, MapPlanner& planner, MapPlan& plan)
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
  // Formats "1.2 %", or "1.2/14 %" for diffuse light and highlights.
  std::string parts_text(const PartErrors& e) const {
    return !needs_.specular  ? percent_text(e.diffuse)
           : !needs_.diffuse ? percent_text(e.specular)
                             : fmt::format("{}/{} %", percent_number(e.diffuse), percent_number(e.specular));
  }
  const char* parts_name() const {
    return !needs_.specular  ? "error of diffuse light"
           : !needs_.diffuse ? "error of highlights"
                             : "error of diffuse light/highlights";
  }
  // Returns the cost of the default bake with a change.
  template <typename Change>
  BakeCost default_with(const Change& change) const {
    BakeShape s = plan_.default_bake.shape;
    change(s);
    return bake_cost(s);
  }
  BakeCost saved_by(const std::function<void(BakeShape&)>& change) const {
    return plan_.default_bake.cost - default_with(change);
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
              fmt::format("no two unit normals differ by more than {:.2g}, so one texel is enough",
                          planner_.survey().normal_range),
              plan_.default_bake.cost - plan_.chosen.cost);
      return;
    }
    double spread = 0.0;
    for (const LevelStatistics& level : planner_.survey().levels)
      if (level.level >= plan_.first_seen) spread = std::max(spread, level.spread_mean);
    if (needs_.width_in_map) {
      add_row("normals under texels", true,
              fmt::format("normals and their BRDFs have a spread of up to {:.2g}", spread));
      return;
    }
    const double without = error_of(0);
    const bool needed = without > scene_.budget.estimate_margin;
    add_row("normals under texels", needed,
            fmt::format("normals have a spread of up to {:.2g}; one mean direction per texel has an error of {}",
                        spread, percent_text(without)));
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
      add_row("several lobes, EM", false, "the normals do not vary, so several lobes are not needed", saved_by(one));
      return;
    }
    add_row("several lobes, EM", needed,
            fmt::format("{} {}: {}", parts_name(), seen_texels(),
                        plan_.candidates.size() == 1
                            ? fmt::format("margin {}", percent_text(scene_.budget.estimate_margin))
                            : fmt::format("the 4 lobes of the default bake have errors of {}, but the limit is {}",
                                          parts_text(plan_.default_bake.error), parts_text(plan_.limit))) +
                (needs_.exponent_max > kEstimatedExponentMax
                     ? fmt::format("; highlights as of s = {:g}", kEstimatedExponentMax)
                     : ""),
            needed ? chosen_without(one) : saved_by(one));
    plan_.effects.back().list = lobes_tried();
    if (needed)
      add_row("aligned lobes", true, "the hardware filters each lobe together with the matching lobes of other texels");
  }

  // Lists items such as "2 lobes": "0.21/45 %, one colour 0.4/45 %", sorted by the number of lobes. The candidates
  // themselves are sorted by textures, so many lobes with a common colour can come before few lobes with one colour
  // each.
  std::vector<PlannedItem> lobes_tried() const {
    std::map<int, PlannedItem> by_count;
    const auto add = [&](bool mean_colours) {
      for (const BakeCandidate& c : plan_.candidates) {
        if (c.shape.representation != plan_.default_bake.shape.representation || c.shape.mean_colours != mean_colours)
          continue;
        PlannedItem& item = by_count[c.shape.lobe_count];
        item.name = count_text(c.shape.lobe_count, "lobe");
        item.value += (mean_colours ? ", one colour " : "") + parts_text(c.error);
      }
    };
    add(false);
    add(true);
    std::vector<PlannedItem> items;
    for (auto& [count, item] : by_count) items.push_back(std::move(item));
    return items;
  }

  // Returns the reason why the representation has no candidates.
  std::string why_not_tried(const RepresentationInfo& other) const {
    if (plan_.is_constant) return "one lobe represents all normals";
    if (needs_.width_in_map || needs_.weighted) return "a roughness map and weights need vMF lobes";
    if (needs_.takes_vmf) return "the BRDF is a sum of vMFs, which needs vMF lobes";
    if (needs_.environment_highlight || other.lobes != nullptr)  // or if one vMF lobe is enough
      return !scene_.environment.empty() ? "an environment needs vMF lobes" : "one vMF lobe is enough";
    return "lobes are enough";
  }

  // Returns the candidate's name within the row of its representation.
  static std::string name_within(const BakeCandidate& c) {
    const RepresentationInfo& info = representation_info(c.shape.representation);
    if (info.lobes != nullptr) return count_text(c.shape.lobe_count, "lobe");
    return info.has_order ? fmt::format("order {}", c.shape.sh_order) : "one Gaussian";
  }

  void add_other_representations() {
    for (const RepresentationInfo& other : representations()) {
      if (other.representation == plan_.default_bake.shape.representation) continue;
      const bool needed = chosen_.representation == other.representation && !plan_.trials;
      std::vector<PlannedItem> tried;
      for (const BakeCandidate& c : plan_.candidates)
        if (c.shape.representation == other.representation)
          tried.push_back({name_within(c),
                           fmt::format("{}, {}", parts_text(c.error), count_text(texture_count(c.shape), "texture"))});
      add_row(other.contents, needed, tried.empty() ? why_not_tried(other) : "estimated errors:");
      plan_.effects.back().list = std::move(tried);
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
    const bool needed = representation_info(chosen_.representation).has_slopes ||  // the spread of slopes depends on
                                                                                   // the direction
                        (anisotropy > 0.5 && chosen_.lobe_count > 1);
    add_row("anisotropic spread", needed,
            plan_.is_constant
                ? "there is no spread"
                : fmt::format("the anisotropy is at most {:.2f} (on a scale from 0 to 1), at level {}{}", anisotropy,
                              at, needed && chosen_.lobe_count > 1 ? ": several round lobes represent it" : ""));
  }

  void add_levels() {
    const bool fine = chosen_.first_level == 0;
    const std::string why = plan_.is_constant ? "all texels of all levels are equal"
                                              : fmt::format("the scene shows levels {} to {} of 0 to {}",
                                                            plan_.first_seen, plan_.last_seen, plan_.level_count - 1);
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
            fmt::format("{}: kept, because the fit starts at the coarsest level; all levels coarser than the last "
                        "visible one together take {:.2g} of the map's size",
                        why, last / 3.0 / (static_cast<double>(plan_.width) * plan_.height)));
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
            fmt::format("{} of the colour variance is between {} lobes; the error of diffuse light is {} with one "
                        "colour per texel, and {} with one colour per lobe",
                        percent_text(correlation), lobes, percent_text(error(ColourModel::kMean)),
                        percent_text(error(ColourModel::kLobes))),
            plan_.chosen.lobe_colours ? chosen_without(none) : saved_by([&](BakeShape& s) {
              s.has_colours = false;
              s.mean_colours = true;
            }));
  }

  void add_precision() {
    if (!representation_info(chosen_.representation).has_kappa) return;
    const auto kept = static_cast<double>(storage_kappa_max(StorageEncoding::kSnorm16));
    const std::optional<double> share =
        is_estimated() ? planner_.share_unrepresentable(chosen_.lobe_count) : std::nullopt;
    if (!share) {
      add_row("32-bit storage", false,
              needs_.width_in_map ? "the roughness map sets the width of highlights"
              : needs_.specular
                  ? fmt::format("highlights have exponents s up to {:.0f}; 16 bits store lobes up to kappa {:.0f}",
                                needs_.exponent_max, kept)
                  : "no highlights");
      return;
    }
    const std::string why = fmt::format(
        "{} of the lobes are too sharp for 16 bits (kappa {:.0f}); highlights have exponents s up to {:.0f}",
        percent_text(*share), kept, needs_.exponent_max);
    if (chosen_.encoding == StorageEncoding::kFloat)
      add_row("32-bit storage", true, why,
              chosen_without([](BakeShape& s) { s.encoding = StorageEncoding::kSnorm16; }));
    else add_row("32-bit storage", false, why);
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
            needs_.width_in_map ? "the roughness map sets the highlight's width"
            : needed            ? fmt::format("at s = {:.4g}{}", needs_.exponent_max,
                                   count > 1 ? fmt::format(" and {:.4g}", needs_.exponent_min) : "")
                                : "there are none",
            needed ? chosen_without(none) : saved_by(none));
  }

  const SceneDescription& scene_;
  MapPlanner& planner_;
  MapPlan& plan_;
  const MapNeeds& needs_;
  const BakeShape& chosen_;
};

}  // namespace

void add_effect_rows(const SceneDescription& scene, MapPlanner& planner, MapPlan& plan) {
  EffectRows(scene, planner, plan).add();
}

}  // namespace multum
