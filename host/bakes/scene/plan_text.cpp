// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/plan_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "host/bakes/settings_search/setting_choice.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/formats/brdf/fresnel.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Wraps words in lines of at most `width` characters. Keeps numbers and their % together.
std::vector<std::string> wrapped(const std::string& text, std::size_t width) {
  std::vector<std::string> words, lines(1);
  std::istringstream stream(text);
  for (std::string word; stream >> word;) {
    if (!words.empty() && word.starts_with("%")) words.back() += " " + word;
    else words.push_back(word);
  }
  for (const std::string& word : words) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > width) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

// If there is room, arranges items in columns that are read line by line.
std::vector<std::string> list_lines(const std::vector<PlannedItem>& list, std::size_t width) {
  std::size_t name = 0, value = 0;
  for (const PlannedItem& item : list) {
    name = std::max(name, item.name.size());
    value = std::max(value, item.value.size());
  }
  const std::size_t column = name + 2 + value, columns = std::max<std::size_t>(1, (width + 3) / (column + 3));
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (i % columns == 0) lines.emplace_back();
    else lines.back().resize((i % columns) * (column + 3), ' ');
    lines.back() += fmt::format("{:<{}} {}", list[i].name + ":", name + 1, list[i].value);
  }
  return lines;
}

std::string effect_rows(const std::vector<PlannedEffect>& effects, int width) {
  constexpr int kEffect = 25, kNeeded = 4, kTime = 9, kBytes = 10;
  constexpr int kWhy = 2 + kEffect + 1 + kNeeded + 1 + kTime + 1 + kBytes + 2;
  // The list is next to the numbers if there is room, otherwise below the numbers.
  const bool beside = width - kWhy >= 40;
  const int indent = beside ? kWhy : 8;
  std::string text;
  for (const PlannedEffect& e : effects) {
    const auto cost = [&](double value, std::string (*text_of)(double)) {
      const double more = e.needed ? value : -value;
      return e.has_cost ? (more < 0.0 ? "-" : "+") + text_of(std::abs(more)) : std::string();
    };
    const std::string ms = cost(e.cost.ms, time_text), bytes = cost(e.cost.bytes, bytes_text);
    std::string line = fmt::format("  {:<{}} {:<{}} {:>{}} {:>{}}", e.effect, kEffect, e.needed ? "yes" : "no", kNeeded,
                                   ms, kTime, bytes, kBytes);
    const auto room = static_cast<std::size_t>(width - indent);
    std::vector<std::string> why = wrapped(e.why, room);
    for (const std::string& items : list_lines(e.list, room)) why.push_back(items);
    if (!beside) line.erase(line.find_last_not_of(' ') + 1);
    for (std::size_t i = 0; i < why.size(); ++i)
      line += i == 0 && beside ? "  " + why[i] : "\n" + std::string(static_cast<std::size_t>(indent), ' ') + why[i];
    text += line + "\n";
  }
  return text;
}

std::string head(const std::string& last) {
  return fmt::format("  {:<25} {:<4} {:>9} {:>10}  {}\n", "effect", "need", "bake", "textures", last);
}

// Formats "2.0 MiB", or "0.7 to 5.3 MiB" if trials decide.
std::string range_text(double low, double high, std::string (*text_of)(double)) {
  if (low == high) return text_of(low);
  const std::string from = text_of(low), to = text_of(high);
  const std::size_t unit = from.find(' ');
  return (to.ends_with(from.substr(unit)) ? from.substr(0, unit) : from) + " to " + to;
}

// Formats "35 % less" or "13 % more".
std::string saved(double from, double to) {
  const double share = from > 0.0 ? 1.0 - to / from : 0.0;
  return fmt::format("{:.0f} % {}", 100.0 * std::abs(share), share < 0.0 ? "more" : "less");
}

Json effects_json(const std::vector<PlannedEffect>& effects) {
  Json rows = Json::array();
  for (const PlannedEffect& e : effects) {
    Json row = {{"effect", e.effect}, {"needed", e.needed}, {"why", e.why}};
    for (const PlannedItem& item : e.list) row["list"].push_back({{"name", item.name}, {"value", item.value}});
    if (e.has_cost) row["bake_ms"] = e.cost.ms, row["bytes"] = e.cost.bytes;
    rows.push_back(std::move(row));
  }
  return rows;
}

Json candidate_json(const BakeCandidate& c) {
  Json json = {{"name", c.name},
               {"ndf", representation_info(c.shape.representation).option},
               {"first_level", c.shape.first_level},
               {"data_format", storage_encoding_name(c.shape.encoding)},
               {"colours", c.shape.has_colours    ? "in the file"
                           : c.shape.mean_colours ? "beside it"
                                                  : "none"},
               {"error", c.error.worst()},
               {"error_diffuse", c.error.diffuse},
               {"error_highlights", c.error.specular},
               {"bake_ms", c.cost.ms},
               {"bytes", c.cost.bytes}};
  if (holds_lobes(c.shape.representation)) json["lobes"] = c.shape.lobe_count;
  if (representation_info(c.shape.representation).has_order) json["sh_order"] = c.shape.sh_order;
  return json;
}

Json map_json(const MapPlan& map, const SceneFiles& files) {
  Json candidates = Json::array();
  for (const BakeCandidate& c : map.candidates) candidates.push_back(candidate_json(c));
  Json json = {{"name", map.name},
               {"input", text_of_path(map.job.input)},
               {"width", map.width},
               {"height", map.height},
               {"seen_levels", {map.first_seen, map.last_seen}},
               {"chosen", candidate_json(map.chosen)},
               {"default", candidate_json(map.default_bake)},
               {"default_error_is_bound", map.default_error_is_bound},
               {"stated_difference", map.stated_difference},
               {"candidates", candidates},
               {"effects", effects_json(map.effects)},
               {"file", text_of_path(fs::path(files.baked(map)).filename().string())}};
  if (map.trials) {
    const BakeCandidate &low = map.trials->fewest, &high = map.trials->most;
    json["trials"] = {{"lobes", {low.shape.lobe_count, high.shape.lobe_count}},
                      {"bytes", {low.cost.bytes, high.cost.bytes}},
                      {"bake_ms", {low.cost.ms, high.cost.ms}}};
  }
  if (map.mean_colours) json["colour_file"] = text_of_path(fs::path(files.colours(map)).filename().string());
  return json;
}

std::string bakes_text(const MapPlan& map) {
  const BakeCandidate& chosen = map.chosen;
  if (!map.trials) return fmt::format("{} from level {}", chosen.name, chosen.shape.first_level);
  return fmt::format("vmf, {} to {} lobes (trials choose the number), from level {}",
                     map.trials->fewest.shape.lobe_count, map.trials->most.shape.lobe_count, chosen.shape.first_level);
}

// Describes the cost of trials, which is not part of the cost model. A trial on a mosaic of 256 x 256 texels takes 0.05
// to 0.7 s on 2 cores of an Intel Xeon with AVX-512 (docs/contributing/ALGORITHMS.md, "Plans of scenes").
std::string trials_text() {
  return fmt::format(" plus the trials (up to {} per map, which take a few seconds in total)",
                     target_candidates(Representation::kMovmf).size());
}

// Describes the cost of the bake and its estimated error.
std::string outcome_text(const MapPlan& map) {
  const BakeCost &by_default = map.default_bake.cost, &least = map.trials ? map.trials->fewest.cost : map.chosen.cost,
                 &most = map.trials ? map.trials->most.cost : map.chosen.cost;
  const auto share = [&](double BakeCost::*value) {
    const std::string low = saved(by_default.*value, least.*value), high = saved(by_default.*value, most.*value);
    return low == high ? low : low + " to " + high;
  };
  return fmt::format(
      "the bake takes {} instead of {} ({}){}, and textures take {} instead of {} ({}); the estimated error is {}{}, "
      "and the error of the default bake is {}{}; pictures differ from the default bake by at most {}{}",
      range_text(least.ms, most.ms, time_text), time_text(by_default.ms), share(&BakeCost::ms),
      map.trials ? trials_text() : "", range_text(least.bytes, most.bytes, bytes_text), bytes_text(by_default.bytes),
      share(&BakeCost::bytes), percent_text(map.chosen.error.worst()),
      map.trials ? " with " + map.chosen.name : std::string(), map.default_error_is_bound ? "at most " : "",
      percent_text(map.default_bake.error.worst()), percent_text(map.stated_difference),
      map.trials ? fmt::format("; the costs in the rows are for {}", map.chosen.name) : "");
}

std::string colour_text(const glm::vec3& c) { return fmt::format("{:.6g},{:.6g},{:.6g}", c.x, c.y, c.z); }

// Makes a path absolute. A service publishes the results folder at another place, where relative paths would not be
// valid.
std::string absolute(const std::string& path) {
  return path.empty() ? "" : fs::absolute(path).lexically_normal().generic_string();
}

// Describes how multum-view draws the object, which is on a plane, at the smallest distance and with a tilt of up to 45
// degrees. The distance is set to 10 units, which determines the size of a unit in metres.
Json view_json(const SceneDescription& scene, const SceneObject& object, const ObjectPlan& plan, const MapPlan& map,
               const SceneFiles& files) {
  constexpr double kUnits = 10.0, kPlaneSize = 60.0;
  const double width = object.width > 0.0 ? object.width : map.width / object.texels_per_metre;
  const double tilt = std::min(object.tilt_max, 45.0) * 0.017453292519943295;
  // The lowest point of the picture is closest to the camera.
  const double below = std::max(tilt - 0.5 * scene.camera.fov_degrees * 0.017453292519943295, 0.0);
  const double nearest = kUnits * std::cos(tilt) / std::cos(below);
  Json view = {{"file", text_of_path(fs::path(files.baked(map)).filename().string())},
               {"size", fmt::format("{}x{}", scene.camera.width, scene.camera.height)},
               {"camera", fmt::format("0,{:.6g},{:.6g},0,30,0,{:.6g}", 30.0 - kUnits * std::sin(tilt),
                                      kUnits * std::cos(tilt), scene.camera.fov_degrees)},
               // The range that multum-view accepts. Outside this range, single texels would not be visible.
               {"repeat", std::clamp(kPlaneSize * object.distance_min / nearest / width, 1e-6, 1e6)}};
  // The inputs for the reference of --compare.
  view["source"] = text_of_path(absolute(map.job.input));
  const char* const roughness = map.job.roughness_is_gloss ? "gloss" : "roughness";
  for (const auto& [key, path] : {std::pair{"albedo", &map.job.albedo}, std::pair{roughness, &map.job.roughness},
                                  std::pair{"weights", &map.job.weights}})
    if (!path->empty()) view[key] = text_of_path(absolute(*path));
  if (map.mean_colours) view["colour_map"] = text_of_path(fs::path(files.colours(map)).filename().string());
  if (map.job.fitting.first_level > 0) view["stored_only"] = true;
  Json brdfs = Json::array();
  for (const std::size_t m : object.materials) {
    const SceneMaterial& material = scene.materials[m];
    const std::string measured = absolute(material.measured_file);
    const Brdf& brdf = material.brdfs.front();
    const bool is_diffuse = !has_highlight(brdf) && !has_fresnel(brdf);
    if (!material.width_in_map) brdfs.push_back(is_diffuse ? "lambert" : brdf_text(brdf, measured));
    if (!measured.empty()) view["measured"] = true;
  }
  if (!brdfs.empty()) view["brdf"] = brdfs;
  for (const std::size_t m : object.materials) {
    const Brdf& brdf = scene.materials[m].brdfs.front();
    view["diffuse"].push_back(colour_text(brdf.diffuse));
    view["specular"].push_back(colour_text(brdf.specular));
  }
  if (plan.fixed_fresnel) view["fixed-fresnel"] = colour_text(glm::vec3(*plan.fixed_fresnel));
  Json lights = Json::array(), point_lights = Json::array();
  for (const SceneLight& light : scene.lights) {
    const std::string place = fmt::format("{:.7g},{:.7g},{:.7g}", light.place.x, light.place.y, light.place.z);
    if (light.is_point)
      point_lights.push_back(place + "," +
                             fmt::format("{:.7g},{:.7g},{:.7g}", light.power.x, light.power.y, light.power.z));
    else lights.push_back(place + fmt::format(",{:.7g}", light.power.x));
  }
  view["light"] = lights;
  view["point_light"] = point_lights;
  if (!scene.environment.empty()) {
    view["environment"] = absolute(scene.environment);
    view["environment_mode"] = plan.environment_by_harmonics ? "sh" : "prefiltered";
  }
  return view;
}

}  // namespace

std::string time_text(double ms) {
  return ms < 999.5 ? fmt::format("{:.0f} ms", ms) : fmt::format("{:.2f} s", 1e-3 * ms);
}

std::string bytes_text(double bytes) {
  if (bytes < 1024.0) return fmt::format("{:.0f} B", bytes);
  if (bytes < 1048576.0) return fmt::format("{:.1f} KiB", bytes / 1024.0);
  return fmt::format("{:.1f} MiB", bytes / 1048576.0);
}

std::string percent_text(double share) { return percent_number(share) + " %"; }

std::string percent_number(double share) {
  return share < 0.0995 ? fmt::format("{:.2g}", 100.0 * share) : fmt::format("{:.0f}", 100.0 * share);
}

std::string plan_text(const SceneDescription& scene, const ScenePlan& plan, int width) {
  width = std::max(width, 60);
  std::string text;
  const auto add = [&](const std::string& words) {
    for (const std::string& line : wrapped(words, static_cast<std::size_t>(width))) text += line + "\n";
  };
  for (const MapPlan& map : plan.maps) {
    add(fmt::format("map {}: {} x {}, the scene shows levels {} to {}; baked as {} instead of {}", map.name, map.width,
                    map.height, map.first_seen, map.last_seen, bakes_text(map), map.default_bake.name));
    text += head("why");
    text += effect_rows(map.effects, width);
    add(outcome_text(map));
    text += "\n";
  }
  for (const ObjectPlan& object : plan.objects) {
    add(fmt::format("object {}: map {}, levels {} to {}; in its shader:", object.name, plan.maps[object.map].name,
                    object.first_level, object.last_level));
    text += effect_rows(object.effects, width);
    text += "\n";
  }
  const bool has_trials = plan.cost_min.bytes < plan.cost_max.bytes;
  add(fmt::format("in total: the bake takes {}{} instead of {}, and textures take {} instead of {}; the plan took {}{}",
                  range_text(plan.cost_min.ms, plan.cost_max.ms, time_text), has_trials ? trials_text() : "",
                  time_text(plan.default_cost.ms), range_text(plan.cost_min.bytes, plan.cost_max.bytes, bytes_text),
                  bytes_text(plan.default_cost.bytes), time_text(1e3 * plan.plan_seconds),
                  scene.budget.bytes ? fmt::format("; budget {}", bytes_text(*scene.budget.bytes)) : ""));
  return text;
}

Json plan_json(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files) {
  Json json = {{"software", std::string("multum ") + MULTUM_VERSION},
               {"bake_ms", plan.cost.ms},
               {"default_bake_ms", plan.default_cost.ms},
               {"bytes", plan.cost.bytes},
               {"default_bytes", plan.default_cost.bytes},
               {"bytes_range", {plan.cost_min.bytes, plan.cost_max.bytes}},
               {"maps", Json::array()},
               {"objects", Json::array()}};
  for (const MapPlan& map : plan.maps) json["maps"].push_back(map_json(map, files));
  for (std::size_t o = 0; o < plan.objects.size(); ++o) {
    const ObjectPlan& object = plan.objects[o];
    const MapPlan& map = plan.maps[object.map];
    json["objects"].push_back({{"name", object.name},
                               {"map", map.name},
                               {"seen_levels", {object.first_level, object.last_level}},
                               {"effects", effects_json(object.effects)},
                               {"stated_difference", object.stated_difference},
                               {"view", view_json(scene, scene.objects[o], object, map, files)}});
  }
  return json;
}

}  // namespace multum
