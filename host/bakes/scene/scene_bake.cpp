// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/scene_bake.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/bakes/bake/bake_file.h"
#include "host/bakes/settings_search/chosen_bake.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/formats/opencl/device_counts.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

std::uint64_t bytes_of(const std::string& path) {
  std::error_code none;
  const auto bytes = std::filesystem::file_size(path, none);
  return none ? 0 : bytes;
}

MipJob colour_job(const MapPlan& map, const std::string& output) {
  MipJob job;
  job.input = map.colour_file;
  job.output = output;
  job.wrap_s = map.job.reading.wrap_s;
  job.wrap_t = map.job.reading.wrap_t;
  job.writing = map.job.writing;
  job.threads = map.job.threads;
  job.force = map.job.force;
  return job;
}

// A target error applies to the BRDF with the narrowest highlight. For a map with roughness, this is the BRDF whose
// width comes from the map.
TargetBrdf target_brdf(const BakeJob& job) {
  if (!job.roughness.empty()) return {};
  return parse_target_brdf(job.measured_exponents.empty()
                               ? std::string("lambert")
                               : fmt::format("blinn-phong:{:.7g}", job.measured_exponents.front()));
}

// If several lobes are needed and there is a target, trials find the number of lobes and the effort of the fit
// (host/bakes/settings_search/chosen_bake.h).
BakeReport bake_lobes_to_target(const BakeJob& job, double target_error, const BakeSource* source, Device& device,
                                Progress* progress, std::string& options) {
  BakeTarget target;
  target.error = target_error;
  target.only = job.representation;
  target.brdf = target_brdf(job);
  ChosenBake chosen = bake_to_target(job, target, source, device, progress);
  if (!chosen.met)
    throw Error(ErrorCode::kVerification,
                fmt::format("{}: no settings reach target_error {:g}; the best settings, {}, have an error of {:.3g}",
                            job.input, target_error, chosen.options, chosen.reached.error));
  options = chosen.options;
  return std::move(chosen.report);
}

// Other settings are based on estimates, so only the bake shows whether they meet the target.
bool misses_target(const SceneDescription& scene, const BakeJob& job, const std::vector<FootprintError>& errors) {
  if (!scene.budget.target_error || errors.empty() || !job.roughness.empty()) return false;
  return !reached_error(errors, target_brdf(job)).meets(*scene.budget.target_error);
}

// Reads the errors of an unchanged file from its row in the report.
std::vector<FootprintError> errors_of(const nlohmann::json& row) {
  std::vector<FootprintError> errors;
  try {
    for (const nlohmann::json& one : row.at("bake").at("error"))
      errors.push_back({parse_accuracy_brdf(one.at("brdf")), one.at("relative_l1"), one.at("confidence_95"),
                        one.at("percentile_95"), one.at("worst_octave"), one.at("worst_octave_relative_l1"),
                        one.at("footprints")});
  } catch (const nlohmann::json::exception&) {
    errors.clear();
  }
  return errors;
}

// `earlier` is the map's row in the earlier report, by which unchanged files are recognised. If there is no such row,
// `earlier` is null.
SceneMapReport bake_map(const SceneDescription& scene, const MapPlan& map, const SceneFiles& files,
                        const nlohmann::json& earlier, Device& device, Progress* progress) {
  const Stopwatch stopwatch;
  SceneMapReport report;
  report.name = map.name;
  BakeJob job = map.job;
  job.output = files.baked(map);
  const bool was_by_trials = earlier.is_object() && earlier.value("by_trials", nlohmann::json()) == true;
  report.is_by_trials = map.trials.has_value() || (scene.budget.target_error && was_by_trials);
  if (!report.is_by_trials) {
    report.bake = bake_file(job, map.source.get(), device, progress);
    report.is_by_trials = misses_target(scene, job, report.bake.unchanged ? errors_of(earlier) : report.bake.error);
  }
  if (report.is_by_trials) {
    if (!holds_lobes(job.representation)) job.encoding = map.default_bake.shape.encoding;
    job.representation = Representation::kMovmf;
    report.bake =
        bake_lobes_to_target(job, *scene.budget.target_error, map.source.get(), device, progress, report.options);
  }
  report.file_bytes = bytes_of(job.output);
  report.has_colours = map.mean_colours;
  if (map.mean_colours) {
    report.colours = bake_mip(colour_job(map, files.colours(map)), device, progress);
    report.file_bytes += bytes_of(files.colours(map));
  }
  report.seconds = stopwatch.seconds();
  return report;
}

// Stores the settings that trials chose as if they had been planned.
void settle(const SceneFiles& files, MapPlan& map) {
  const MovmfReader reader(files.baked(map));
  BakeCandidate& chosen = map.chosen;
  chosen.shape.representation = reader.header().header.representation;
  chosen.shape.encoding = reader.header().header.encoding;
  chosen.shape.lobe_count = reader.header().lobe_count();
  chosen.name = fmt::format("{}, {} lobe{}", representation_info(chosen.shape.representation).option,
                            chosen.shape.lobe_count, chosen.shape.lobe_count == 1 ? "" : "s");
  chosen.cost = bake_cost(chosen.shape);
  map.trials.reset();
}

nlohmann::json map_row(const SceneMapReport& map, const MapPlan& planned) {
  if (!map.earlier.empty()) {
    nlohmann::json row = nlohmann::json::parse(map.earlier);
    if (map.bake.unchanged) row["unchanged"] = true;
    return row;
  }
  nlohmann::json row = {{"name", map.name},
                        {"seconds", map.seconds},
                        {"file_bytes", map.file_bytes},
                        {"estimate_ms", planned.chosen.cost.ms},
                        {"default_estimate_ms", planned.default_bake.cost.ms},
                        {"bytes", planned.chosen.cost.bytes},
                        {"bytes_saved", planned.default_bake.cost.bytes - planned.chosen.cost.bytes},
                        {"ms_saved_estimate", planned.default_bake.cost.ms - planned.chosen.cost.ms},
                        {"by_trials", map.is_by_trials},
                        {"bake", nlohmann::json::parse(map.bake.to_json())}};
  if (!map.options.empty()) row["options"] = map.options;
  if (map.difference)
    row["difference_from_default"] = {{"brdf", map.difference->part},
                                      {"error", map.difference->error},
                                      {"confidence", map.difference->confidence},
                                      {"worst_level", map.difference->worst_level},
                                      {"worst_level_error", map.difference->worst_error},
                                      {"worst_level_confidence", map.difference->worst_confidence},
                                      {"at_most", map.difference->at_most()}};
  if (map.has_colours) row["colours"] = nlohmann::json::parse(map.colours.to_json());
  return row;
}

}  // namespace

SceneMapRows earlier_rows(const std::string& path) {
  SceneMapRows rows;
  const nlohmann::json report = nlohmann::json::parse(json_of_file(path).value_or(""), nullptr, false);
  if (!report.is_object() || !report.contains("maps") || !report["maps"].is_array()) return rows;
  for (const nlohmann::json& row : report["maps"])
    if (row.is_object() && row.contains("name") && row["name"].is_string()) rows[row["name"]] = row.dump();
  return rows;
}

SceneReport bake_scene_maps(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files,
                            const SceneMapRows& earlier, Device& device, const SceneMapDone& done, Progress* progress) {
  const Stopwatch stopwatch;
  const DeviceCounts counts(device);  // counts this share only, because a process may bake several shares
  SceneReport report;
  report.plan = plan;
  for (const MapPlan& map : report.plan.maps) {
    const auto row = earlier.find(map.name);
    const std::string before = row != earlier.end() ? row->second : "null";
    report.maps.push_back(bake_map(scene, map, files, nlohmann::json::parse(before, nullptr, false), device, progress));
    SceneMapReport& made = report.maps.back();
    if (made.bake.unchanged && row != earlier.end()) made.earlier = before;
    if (done) done(map, made);
  }
  report.launches = counts.launches();
  report.builds = counts.builds();
  report.seconds = stopwatch.seconds();
  return report;
}

void compare_scene_maps(const SceneDescription& scene, const ScenePlan& plan, SceneReport& report, Device& device,
                        Progress* progress) {
  const Stopwatch comparing;
  for (std::size_t m = 0; m < plan.maps.size(); ++m) {
    const MapPlan& map = plan.maps[m];
    const SceneMapReport& made = report.maps[m];
    if (map.mosaics == nullptr || map.stated_difference == 0.0 || made.is_by_trials || !made.earlier.empty()) continue;
    progress_stage(progress, "compare with the default bake");
    report.maps[m].difference = measure_difference(scene, map, device, progress);
  }
  report.compare_seconds = comparing.seconds();
}

void write_settled_plan(const SceneDescription& scene, const SceneFiles& files, SceneReport& report) {
  report.plan.cost = {};
  bool is_settled = false;
  for (std::size_t m = 0; m < report.maps.size(); ++m) {
    if (report.maps[m].is_by_trials) settle(files, report.plan.maps[m]), is_settled = true;
    report.plan.cost += report.plan.maps[m].chosen.cost;
  }
  report.plan.cost_min = report.plan.cost_max = report.plan.cost;
  if (is_settled) write_text_file(files.plan(), json_text(plan_json(scene, report.plan, files), 2) + "\n");
}

SceneReport bake_scene(const SceneDescription& scene, const ScenePlan& plan, const SceneFiles& files, Device& device,
                       const SceneMapDone& done, Progress* progress) {
  write_text_file(files.plan(), json_text(plan_json(scene, plan, files), 2) + "\n");
  SceneReport report = bake_scene_maps(scene, plan, files, earlier_rows(files.report()), device, done, progress);
  write_settled_plan(scene, files, report);
  compare_scene_maps(scene, plan, report, device, progress);
  write_text_file(files.report(), json_text(report.to_json(), 2) + "\n");
  return report;
}

nlohmann::json SceneReport::to_json() const {
  nlohmann::json json = {{"seconds", seconds},
                         {"plan_seconds", plan.plan_seconds},
                         {"compare_seconds", compare_seconds},
                         {"default_estimate_ms", plan.default_cost.ms},
                         {"bytes", plan.cost.bytes},
                         {"bytes_saved", plan.default_cost.bytes - plan.cost.bytes},
                         {"ms_saved_estimate", plan.default_cost.ms - plan.cost.ms},
                         {"launches", launches},
                         {"builds", builds},
                         {"maps", nlohmann::json::array()}};
  json["maps"] = map_rows();
  return json;
}

nlohmann::json SceneReport::map_rows() const {
  nlohmann::json rows = nlohmann::json::array();
  for (std::size_t m = 0; m < maps.size(); ++m) rows.push_back(map_row(maps[m], plan.maps[m]));
  return rows;
}

std::string SceneReport::to_text() const {
  std::string text;
  for (const auto& [kernel, count] : launches) text += fmt::format("  {:<28} {:>8} launches\n", kernel, count);
  for (const auto& [file, count] : builds)
    text += fmt::format("  {:<28} {:>8} program{} built\n", file + ".cl", count, count == 1 ? "" : "s");
  bool all_unchanged = true;
  for (std::size_t m = 0; m < maps.size(); ++m) {
    const SceneMapReport& map = maps[m];
    all_unchanged &= map.bake.unchanged && (!map.has_colours || map.colours.unchanged);
    if (const auto& d = map.difference)
      text += fmt::format(
          "{}: differs from the default bake by {} ({}, 95 % interval), and by at most {} at the worst level (level "
          "{})\n",
          map.name, error_text(d->error, d->confidence), d->part, percent_text(d->at_most()), d->worst_level);
    else if (plan.maps[m].stated_difference == 0.0 && !map.is_by_trials)
      text += fmt::format("{}: identical to the default bake\n", map.name);
  }
  const double bytes = plan.default_cost.bytes - plan.cost.bytes;
  const std::string textures =
      fmt::format("textures take {}, which is {} {} than in the default bake\n", bytes_text(plan.cost.bytes),
                  bytes_text(std::abs(bytes)), bytes < 0.0 ? "more" : "less");
  if (all_unchanged)
    return text +
           fmt::format("nothing to bake, because all files exist; the plan took {}; ",
                       time_text(1e3 * plan.plan_seconds)) +
           textures;
  return text +
         fmt::format(
             "the bake took {}, the plan {} and the comparison {} (predicted for this bake: {}; for the default bake: "
             "{}); ",
             time_text(1e3 * seconds), time_text(1e3 * plan.plan_seconds), time_text(1e3 * compare_seconds),
             time_text(plan.cost.ms), time_text(plan.default_cost.ms)) +
         textures;
}

}  // namespace multum
