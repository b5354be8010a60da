// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/scene/scene_share.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "host/formats/opencl/program_cache.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/share_record.h"
#include "host/foundation/base/version.h"
#include "host/foundation/base/work_shard.h"

namespace multum {
namespace {

using Json = nlohmann::json;

// The hashes of a map's two files. A hash is empty if its file does not exist.
struct FileHashes {
  std::string baked, colours;
};

struct RecordedMap {
  std::string name;
  FileHashes hashes;
  Json row;  // row of the report
  bool is_whole = false;
  std::string why;  // reason if the record is unusable
};

struct Record {
  std::vector<RecordedMap> maps;
  double seconds = 0.0, plan_seconds = 0.0, compare_seconds = 0.0;
  std::map<std::string, std::uint64_t> launches;
  std::map<std::string, int> builds;
};

bool has_shared_budget(const SceneDescription& scene) { return scene.budget.bytes || scene.budget.bake_ms; }

std::vector<std::size_t> maps_of_share(const SceneDescription& scene, int index, int count) {
  const WorkShard shard{index, index, count};
  std::vector<std::size_t> maps;
  for (std::size_t m = 0; m < scene.maps.size(); ++m)
    if (shard.has(m)) maps.push_back(m);
  return maps;
}

// Returns a scene that contains only these maps and the objects that show them.
SceneDescription part_of(const SceneDescription& scene, const std::vector<std::size_t>& maps) {
  SceneDescription part = scene;
  part.maps.clear();
  part.objects.clear();
  for (const std::size_t m : maps) part.maps.push_back(scene.maps[m]);
  for (SceneObject object : scene.objects) {
    const auto at = std::find(maps.begin(), maps.end(), object.map);
    if (at == maps.end()) continue;
    object.map = static_cast<std::size_t>(at - maps.begin());
    part.objects.push_back(std::move(object));
  }
  return part;
}

// Returns all inputs on which the files of these maps and their rows in the report depend.
std::string key_of(const SceneRun& run, const std::vector<std::size_t>& own) {
  const SceneDescription& scene = run.scene;
  InputHashes& hashes = *scene.maps.front().job.hashes;
  std::vector<std::string> files = {run.scene_file};
  if (!scene.environment.empty()) files.push_back(scene.environment);
  for (const SceneMaterial& material : scene.materials)
    if (!material.measured_file.empty()) files.push_back(material.measured_file);
  std::vector<std::size_t> maps = own;
  if (has_shared_budget(scene)) maps = maps_of_share(scene, 1, 1);
  for (const std::size_t m : maps)
    for (const std::string& file : input_files(scene.maps[m].job)) files.push_back(file);
  ContentHash hash;
  hash.update(fmt::format("{} {}\n", software_version(), kernel_sources_hash()));
  for (const std::string& file : files) hash.update(hashes.hash(file) + "\n");
  return hash.finish();
}

ShareName name_of(const SceneRun& run, int index, int count) { return {run.files.folder, "scene", index, count}; }

// If the file differs from the file that its share wrote, returns the difference. Otherwise returns an empty string.
std::string difference(const std::string& path, const std::string& expected) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return path + ": does not exist";
  return hash_file(path) == expected ? "" : path + ": is damaged, or belongs to another bake";
}

RecordedMap map_from(const SceneRun& run, const Json& json, const std::string& name) {
  RecordedMap map;
  map.name = json.at("name").get<std::string>();
  map.hashes = {json.at("baked").get<std::string>(), json.at("colours").get<std::string>()};
  map.row = json.at("row");
  if (map.name != name || !map.row.is_object() || map.row.value("name", Json()) != name)
    throw Error(ErrorCode::kEnvironment, fmt::format("has map '{}', expected '{}'", map.name, name));
  MapPlan plan;
  plan.name = name;
  map.why = difference(run.files.baked(plan), map.hashes.baked);
  if (map.why.empty() && !map.hashes.colours.empty()) map.why = difference(run.files.colours(plan), map.hashes.colours);
  map.is_whole = map.why.empty();
  return map;
}

Record record_from(const SceneRun& run, const Json& content, const std::vector<std::size_t>& own) {
  Record record;
  const Json& maps = content.at("maps");
  if (!maps.is_array() || maps.size() != own.size())
    throw Error(ErrorCode::kEnvironment, fmt::format("has {} maps, expected {}", maps.size(), own.size()));
  for (std::size_t i = 0; i < own.size(); ++i)
    record.maps.push_back(map_from(run, maps[i], run.scene.maps[own[i]].name));
  record.seconds = content.at("seconds").get<double>();
  record.plan_seconds = content.at("planSeconds").get<double>();
  record.compare_seconds = content.at("compareSeconds").get<double>();
  record.launches = content.at("launches").get<std::map<std::string, std::uint64_t>>();
  record.builds = content.at("builds").get<std::map<std::string, int>>();
  return record;
}

// Throws Error(kEnvironment) that names the record and the option that writes it again.
Record read_record(const SceneRun& run, const ShareName& name, const std::vector<std::size_t>& own) {
  const Json content = read_share_record(name, key_of(run, own));
  const auto refuse = [&](const std::string& what) -> Record {
    throw Error(ErrorCode::kEnvironment, name.path() + ": " + what + name.remedy());
  };
  try {
    return record_from(run, content, own);
  } catch (const Json::exception& error) {
    return refuse(std::string("is not a record of baked maps: ") + error.what());
  } catch (const Error& error) {
    return refuse(error.what());
  }
}

std::optional<Record> record_there(const SceneRun& run, const ShareName& name, const std::vector<std::size_t>& own) {
  try {
    return read_record(run, name, own);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kEnvironment) throw;
    return std::nullopt;
  }
}

// The part of the plan that a share bakes.
ScenePlan plan_share(const SceneRun& run, const SceneDescription& part, const std::vector<std::size_t>& own,
                     Progress* progress) {
  if (!has_shared_budget(run.scene)) return plan_scene(part, run.planning, progress);
  ScenePlan plan = plan_scene(run.scene, run.planning, progress);
  std::vector<MapPlan> maps;
  for (const std::size_t m : own) maps.push_back(std::move(plan.maps[m]));
  plan.maps = std::move(maps);
  return plan;
}

Json content_of(const SceneRun& run, const SceneReport& report) {
  const Json rows = report.map_rows();
  Json content = {{"seconds", report.seconds},
                  {"planSeconds", report.plan.plan_seconds},
                  {"compareSeconds", report.compare_seconds},
                  {"launches", report.launches},
                  {"builds", report.builds},
                  {"maps", Json::array()}};
  for (std::size_t m = 0; m < report.maps.size(); ++m) {
    const MapPlan& map = report.plan.maps[m];
    content["maps"].push_back({{"name", map.name},
                               {"baked", hash_file(run.files.baked(map))},
                               {"colours", map.mean_colours ? hash_file(run.files.colours(map)) : ""},
                               {"row", rows[m]}});
  }
  return content;
}

template <typename Count>
void add_counts(const std::map<std::string, Count>& from, std::map<std::string, Count>& to) {
  for (const auto& [name, count] : from) to[name] += count;
}

}  // namespace

SceneShareReport bake_scene_share(const SceneRun& run, int index, int count, Device& device, const SceneMapDone& done,
                                  Progress* progress) {
  const std::vector<std::size_t> own = maps_of_share(run.scene, index, count);
  const ShareName name = name_of(run, index, count);
  const auto maps = static_cast<int>(own.size());
  const std::optional<Record> there = record_there(run, name, own);
  const auto is_whole = [](const RecordedMap& map) { return map.is_whole; };
  if (there && !run.force && std::all_of(there->maps.begin(), there->maps.end(), is_whole)) return {true, maps};
  SceneReport report;
  if (!own.empty()) {
    const SceneDescription part = part_of(run.scene, own);
    ScenePlan plan = plan_share(run, part, own, progress);
    SceneMapRows earlier = earlier_rows(run.files.report());
    for (std::size_t i = 0; there && i < own.size(); ++i) {
      if (there->maps[i].is_whole) earlier[plan.maps[i].name] = there->maps[i].row.dump();
      else plan.maps[i].job.force = true;  // the header does not show whether texels are damaged
    }
    report = bake_scene_maps(part, plan, run.files, earlier, device, done, progress);
    compare_scene_maps(part, plan, report, device, progress);
  }
  write_share_record(name, key_of(run, own), content_of(run, report));
  return {false, maps};
}

SceneReport merge_scene(const SceneRun& run, int count, Progress* progress) {
  std::vector<RecordedMap> maps(run.scene.maps.size());
  SceneReport report;
  std::string missing;
  double plan_seconds = 0.0;
  progress_stage(progress, "check shares");
  for (int i = 1; i <= count; ++i) {
    const std::vector<std::size_t> own = maps_of_share(run.scene, i, count);
    const ShareName name = name_of(run, i, count);
    const auto miss = [&](const std::string& why) { missing += (missing.empty() ? "" : "\n  ") + why; };
    try {
      Record record = read_record(run, name, own);
      for (std::size_t m = 0; m < own.size(); ++m) {
        if (!record.maps[m].is_whole) miss(record.maps[m].why + name.remedy());
        maps[own[m]] = std::move(record.maps[m]);
      }
      report.seconds += record.seconds;
      plan_seconds += record.plan_seconds;
      report.compare_seconds += record.compare_seconds;
      add_counts(record.launches, report.launches);
      add_counts(record.builds, report.builds);
    } catch (const Error& error) {
      if (error.code() != ErrorCode::kEnvironment) throw;
      miss(error.what());
    }
  }
  if (!missing.empty()) throw Error(ErrorCode::kEnvironment, missing);
  PlanSettings planning = run.planning;
  planning.for_bake = false;
  planning.kept_bytes_max = 0;
  report.plan = plan_scene(run.scene, planning, progress);
  report.plan.plan_seconds += plan_seconds;
  write_text_file(run.files.plan(), json_text(plan_json(run.scene, report.plan, run.files), 2) + "\n");
  for (RecordedMap& map : maps) {
    SceneMapReport& made = report.maps.emplace_back();
    made.name = map.name;
    made.is_by_trials = map.row.value("by_trials", Json()) == true;
    made.earlier = map.row.dump();
  }
  write_settled_plan(run.scene, run.files, report);
  write_text_file(run.files.report(), json_text(report.to_json(), 2) + "\n");
  return report;
}

}  // namespace multum
