// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/object_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/bakes/scene/plan_text.h"
#include "host/bakes/scene/seen_levels.h"
#include "host/formats/brdf/facet_distribution.h"
#include "host/formats/brdf/fresnel.h"

namespace multum {
namespace {

// In an environment, multum-view evaluates harmonics of order 8. They suffice for highlights with exponents below this
// limit. For Blinn-Phong with s = 12, they miss 8 % (docs/contributing/ALGORITHMS.md, "Environments").
constexpr double kHarmonicsExponentMax = 12.0;

void add_row(ObjectPlan& object, const std::string& effect, bool needed, const std::string& why) {
  object.effects.push_back({effect, needed, why, false, {}});
}

// The smallest v.h is the cosine of half the largest angle between the line of sight and the light. The line of sight
// is within `tilt` of the surface's normal, and the light may come from the horizon of the steepest normal.
double least_half_cosine(double tilt_degrees, double z_min) {
  const double steepest = std::acos(std::clamp(z_min, 0.0, 1.0));
  const double between = tilt_degrees * std::numbers::pi / 180.0 + 0.5 * std::numbers::pi + steepest;
  return std::cos(0.5 * std::min(between, std::numbers::pi));
}

void add_fresnel(const SceneDescription& scene, const SceneObject& object, const MapPlan& map, ObjectPlan& plan) {
  const auto brdf_of = [&](std::size_t m) -> const Brdf& { return scene.materials[m].brdfs.front(); };
  const bool has_any = std::any_of(object.materials.begin(), object.materials.end(),
                                   [&](std::size_t m) { return has_fresnel(brdf_of(m)); });
  if (!has_any) return add_row(plan, "Fresnel", false, "the BRDF has no Fresnel term");
  if (!scene.environment.empty()) return add_row(plan, "Fresnel", true, "environment light comes from all directions");
  if (object.materials.size() > 1) return add_row(plan, "Fresnel", true, "one of several BRDFs has a Fresnel term");
  const double v_h = least_half_cosine(object.tilt_max, map.z_min), margin = scene.budget.estimate_margin;
  const FixedFresnel fixed = fixed_fresnel(brdf_of(object.materials.front()), v_h);
  const bool needed = fixed.change > margin;
  const std::string bound = fmt::format(
      "v.h is at least {:.2f} (tilt {:g} degrees, normals up to {:.0f} degrees): a constant Fresnel term has an error "
      "of at most {}, and the margin is {}",
      v_h, object.tilt_max, std::acos(std::clamp(map.z_min, 0.0, 1.0)) * 180.0 / std::numbers::pi,
      percent_text(fixed.change), percent_text(margin));
  add_row(plan, "Fresnel", needed, bound);
  if (needed) return;
  plan.fixed_fresnel = fixed.value;
  plan.stated_difference += fixed.change;
}

}  // namespace

ObjectPlan plan_object(const SceneDescription& scene, const SceneObject& object, const MapPlan& map) {
  ObjectPlan plan;
  plan.name = object.name;
  plan.map = object.map;
  const SeenLevels seen = seen_levels(scene.camera, object, map.width, map.level_count);
  plan.first_level = seen.first;
  plan.last_level = seen.last;
  bool highlight = false, dynamic = false, width_in_map = false;
  double exponent = 0.0;
  for (const std::size_t m : object.materials) {
    const SceneMaterial& material = scene.materials[m];
    dynamic |= material.is_dynamic();
    width_in_map |= material.width_in_map;
    for (const Brdf& brdf : material.brdfs) {
      highlight |= has_highlight(brdf);
      if (has_highlight(brdf)) exponent = std::max(exponent, equivalent_exponent(brdf));
    }
  }
  const bool environment = !scene.environment.empty();
  plan.environment_by_harmonics = environment && highlight && exponent <= kHarmonicsExponentMax;
  add_row(plan, "highlight", highlight,
          !highlight     ? "the material is diffuse"
          : width_in_map ? "the roughness map sets the width of the highlight"
                         : fmt::format("the highlight is as sharp as Blinn-Phong with s = {:.4g}", exponent));
  plan.stated_difference = map.stated_difference;
  add_fresnel(scene, object, map, plan);
  add_row(plan, "width as a uniform", dynamic, dynamic ? "the material changes at run time" : "the material is fixed");
  const auto points = std::count_if(scene.lights.begin(), scene.lights.end(), [](const auto& l) { return l.is_point; });
  const auto distant = static_cast<std::ptrdiff_t>(scene.lights.size()) - points;
  add_row(plan, "distant lights", distant > 0, fmt::format("the scene has {}", distant));
  add_row(plan, "point lights", points > 0, fmt::format("the scene has {}", points));
  add_row(plan, "environment, diffuse", environment,
          environment ? "harmonics up to order 2 represent all but 1 % of diffuse light" : "the scene has none");
  add_row(plan, "environment, highlight", environment && highlight,
          !environment ? "the scene has none"
          : !highlight ? "the material has no highlight"
          : plan.environment_by_harmonics
              ? "harmonics up to order 8, because the highlight is broad"
              : fmt::format("prefiltered mips, because order 8 suffices only up to s = {:.0f}", kHarmonicsExponentMax));
  return plan;
}

}  // namespace multum
