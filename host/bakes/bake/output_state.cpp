// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/output_state.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/ndf_bake.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/reading_settings.h"
#include "host/formats/image/normals/tile_set.h"
#include "host/formats/opencl/program_cache.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/version.h"

namespace multum {
namespace {

// Formats a float with as few digits as possible. For example, JSON would write 0.01 as 0.00999999977.
std::string shown(const nlohmann::json& json, const std::string& key) {
  const auto found = json.find(key);
  if (found == json.end()) return "not stated";
  return found->is_number_float() ? fmt::format("{:g}", found->get<double>()) : found->dump();
}

// The words that replace settings that are hashes of maps.
const std::map<std::string, std::string> kHashedMaps = {
    {"albedo", "albedo"}, {"roughness", "roughness map"}, {"weights", "weight map"}};

// Lists the settings that differ, with both values. Hashes are replaced with words.
std::vector<std::string> changed_settings(const std::string& there, const std::string& now) {
  const nlohmann::json old_json = nlohmann::json::parse(there, nullptr, false);
  const nlohmann::json new_json = nlohmann::json::parse(now);
  if (!old_json.is_object()) return {"its settings cannot be parsed"};
  std::set<std::string> keys;
  for (const nlohmann::json* json : {&old_json, &new_json})
    for (const auto& [key, value] : json->items()) keys.insert(key);
  std::vector<std::string> changes;
  for (const std::string& key : keys) {
    if (old_json.contains(key) && new_json.contains(key) && old_json[key] == new_json[key]) continue;
    if (const auto map = kHashedMaps.find(key); map != kHashedMaps.end())
      changes.push_back(fmt::format("the {} has changed", map->second));
    else if (key == "kernels") changes.emplace_back("it was baked with kernels that differ from those of this program");
    else changes.push_back(fmt::format("{} was {} and is now {}", key, shown(old_json, key), shown(new_json, key)));
  }
  return changes;
}

// If the bake chooses its own settings, compares only the target and the inputs, because the settings are not known
// until the map is baked.
std::vector<std::string> changed_target(const std::string& there, const std::string& now) {
  const nlohmann::json old_json = nlohmann::json::parse(there, nullptr, false);
  const nlohmann::json new_json = nlohmann::json::parse(now);
  if (!old_json.is_object()) return {"its settings cannot be parsed"};
  if (old_json.value("kernels", "") != new_json.at("kernels").get<std::string>())
    return {"it was baked with kernels that differ from those of this program"};
  if (!old_json.contains("target")) return {"its settings were not chosen for a target"};
  const std::string was = old_json["target"].dump(), is = new_json["target"].dump();
  const auto words = [](const std::string& target) { return target.substr(1, target.rfind(", ") - 1); };
  if (was == is) return {};
  if (words(was) == words(is)) return {"its other settings or maps have changed"};
  return {fmt::format("its settings were chosen for {}, expected {}", words(was), words(is))};
}

std::optional<BakedProvenance> read_provenance(const std::string& path, std::string& why_not) {
  try {
    return read_baked_header(path).provenance;
  } catch (const Error& error) {
    why_not = error.what();
    return std::nullopt;
  }
}

}  // namespace

MovmfSettings fitting_settings(const BakeJob& job, WrapMode wrap_s, WrapMode wrap_t) {
  MovmfSettings settings = job.fitting;
  if (holds_lobes(job.representation)) settings.representation = job.representation;
  settings.periodic_x = wrap_s == WrapMode::kPeriodic;
  settings.periodic_y = wrap_t == WrapMode::kPeriodic;
  return settings;
}

std::string rows_key(const BakedProvenance& from) {  // the settings contain the albedo's hash
  return hash_text(fmt::format("{}\n{}\n{}", from.software, from.settings, from.source_hash));
}

std::string all_settings_json(const BakeJob& job) {
  nlohmann::json json = nlohmann::json::parse(ndf_bake(job.representation).settings(job));
  add_reading_settings(job.reading, json);
  if (job.reading.tiles != nullptr) json["tile"] = job.reading.tile;
  // Adds the surface only if it is interpolated, so that the hash of files from earlier program versions does not
  // change.
  if (job.surface == MapSurface::kInterpolated) json["surface"] = map_surface_name(job.surface);
  json["encoding"] = storage_encoding_name(job.encoding);
  json["compression"] = job.writing.compression;
  json["albedo"] = job.albedo.empty() ? "" : job.hashes->hash(job.albedo);
  // Without weights, the text is the same as in earlier program versions, which did not support weights.
  if (!job.weights.empty()) json["weights"] = job.hashes->hash(job.weights);
  if (!job.roughness.empty()) {
    const ChannelFile file = roughness_file(job);
    json["roughness"] = job.hashes->hash(file.path) + (file.channel.empty() ? "" : ":" + file.channel) +
                        (file.is_gloss ? ", gloss" : "");
  }
  if (!job.onto.empty()) {
    if (job.region) json["region"] = {job.region->x, job.region->y, job.region->width, job.region->height};
    else json["region"] = "auto";  // placeholder until the region is computed
    json["onto"] = read_baked_header(job.onto).provenance.content_hash;
  }
  if (!job.chosen_for.empty()) json["target"] = job.chosen_for;
  json["kernels"] = kernel_sources_hash().substr(0, 16);
  return json_text(json);
}

OutputState find_output_state(const BakeJob& job, const std::string& settings) {
  std::error_code none;
  if (!std::filesystem::is_regular_file(job.output, none)) return {OutputFinding::kMissing, "", {}};
  OutputState state{OutputFinding::kInPlace, "", {}};
  const std::optional<BakedProvenance> there = read_provenance(job.output, state.why);
  if (!there) {
    state.finding = OutputFinding::kUnreadable;
    return state;
  }
  std::vector<std::string> reasons;
  if (there->file_hash() != job.hashes->hash(job.input)) reasons.emplace_back("the source has changed");
  else if (!there->source_tiles.empty() && job.reading.tiles != nullptr &&
           !tiles_are_unchanged(there->source_tiles, *job.reading.tiles, job.reading.tile, job.reading.fix_nan))
    reasons.emplace_back("other tiles of its set that affect its borders or its green axis have changed");
  if (there->software != software_version())
    reasons.push_back(fmt::format("it was baked by {}, but this program is {}", there->software, software_version()));
  if (there->settings != settings)
    for (std::string& change : job.chosen_for.empty() ? changed_settings(there->settings, settings)
                                                      : changed_target(there->settings, settings))
      reasons.push_back(std::move(change));
  const auto stated = parse_measured_error(there->measured_error);
  if (stated) state.stated = *stated;
  if (job.measure && state.stated.rows.empty()) reasons.emplace_back("its error was not measured");
  if (reasons.empty()) return state;
  state.finding = OutputFinding::kStale;
  state.why = fmt::format("{}", fmt::join(reasons, "; "));
  return state;
}

}  // namespace multum
