// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/forms/chosen_form.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace multum {
namespace {

std::string text_of(const FormView& view) {
  if (view.shape.empty()) return fmt::format("at {:.3g} m", view.distance);
  return fmt::format("on a {} at {:.3g} texel{} per pixel", view.shape, view.distance, view.distance == 1.0 ? "" : "s");
}

// Returns the view in which two forms differ most.
std::size_t most_different(const FormError& one, const FormError& other) {
  std::size_t at = 0;
  for (std::size_t i = 1; i < one.by_view.size(); ++i)
    if (std::abs(one.by_view[i] - other.by_view[i]) > std::abs(one.by_view[at] - other.by_view[at])) at = i;
  return at;
}

}  // namespace

std::string ChosenForm::to_text(bool has_own_maps) const {
  if (views.empty()) return "the pictures do not show this material";
  const bool has_candidates = errors.contains("lobes_4");
  const FormError &before = errors.at("plain"), &after = errors.at(has_candidates ? "lobes_4" : "chosen");
  const std::size_t at = most_different(before, after);
  const auto percent = [&](const char* name) { return fmt::format("{:.1f} %", errors.at(name).by_view[at]); };
  std::string text =
      fmt::format("{}: plain mips {}, export {}", text_of(views[at]), percent("plain"), percent("chosen"));
  if (has_candidates) text += fmt::format(", with 4 evaluations {}, lobes {}", percent("points_4"), percent("lobes_4"));
  text += "; ";
  if (normals.has_fitted_normals()) text += "fitted normals and roughness";
  else if (normals.is_plain()) text += has_own_maps ? "its own maps stay" : "averages";
  else text += has_own_maps ? "keeps its normals, fitted roughness" : "averaged normals, fitted roughness";
  if (has_candidates) text += has_lobes ? ", with lobes" : ", without lobes";
  if (has_lobe_colours && errors.contains("lobe_colours_4")) {
    const FormError &own = errors.at("lobe_colours_4"), &mean = errors.at("mean_colour_4");
    const std::size_t there = most_different(own, mean);
    text += fmt::format(
        " that have colours ({} the error is {:.1f} % with one colour per lobe, and {:.1f} % with one colour per "
        "texel)",
        text_of(views[there]), own.by_view[there], mean.by_view[there]);
  }
  return text;
}

nlohmann::ordered_json ChosenForm::to_json() const {
  nlohmann::ordered_json made = {{"distances", nlohmann::ordered_json::array()}};
  for (const FormView& view : views) {
    made["distances"].push_back(view.distance);
    if (!view.shape.empty()) made["shapes"].push_back(view.shape);
  }
  made["on_sphere"] = is_on_sphere;
  made["lobes"] = has_lobes;
  made["lobe_colours"] = has_lobe_colours;
  for (const auto& [name, error] : errors) made["errors"][name] = error.by_view;
  for (const LevelForm& level : normals.levels)
    made["levels"].push_back({{"fitted_normals", level.has_fitted_normals}, {"fitted_roughness", level.fitted_share}});
  return made;
}

}  // namespace multum
