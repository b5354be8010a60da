// SPDX-License-Identifier: Apache-2.0
// Reads the maps one by one, with the values of [defaults] for keys that a map does not set. Then compares all maps,
// because no two maps may have the same output.
#include "host/bakes/manifest/bake_manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "host/bakes/bake/bake_batch.h"
#include "host/bakes/bake/job_parameters.h"
#include "host/formats/brdf/brdf_text.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/udim_set.h"
#include "host/foundation/toml/parameter_keys.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kWholeFile[] = "the manifest";

std::vector<std::string> default_keys() {
  std::vector<std::string> keys = bake_parameters().names(kInManifest);
  std::erase(keys, "input");
  return keys;
}

std::vector<std::string> map_keys() {
  std::vector<std::string> keys = bake_parameters().names(kInManifest);
  keys.emplace_back("output");
  return keys;
}

// Keys of the material maps, and the corresponding members of the job.
constexpr std::pair<const char*, std::string BakeJob::*> kMaterialKeys[] = {
    {"albedo", &BakeJob::albedo}, {"roughness", &BakeJob::roughness}, {"weights", &BakeJob::weights}};

bool has_target(const ParameterValues& values) { return values.has("target_error") || values.has("budget_ms"); }

// The values of a map override the defaults. If the map has a target, default settings are removed. If it has settings,
// the default target is removed.
void read_values(const StrictTable& table, ParameterValues& values) {
  if (table.has("target_error") || table.has("budget_ms")) values = without_those_of_target(values);
  read_parameters(table, kInManifest, values);
  if (const Parameter* chosen = given_of_target(values); chosen != nullptr && has_target(values)) {
    for (const char* target : {"target_error", "budget_ms"}) {
      if (table.has(target))
        table.refuse(chosen->name,
                     fmt::format("and {} are mutually exclusive, because a target chooses this setting", target));
      values.erase(target);
    }
  }
  for (const char* key : {"brdf", "best_effort"})
    if (table.has(key) && !has_target(values)) table.refuse(key, "needs target_error or budget_ms, found neither");
}

// Returns the target for an error or a time, or nullopt if neither is given.
BakeTarget target_of(const StrictTable& table, const std::string& manifest, const ParameterValues& values) {
  BakeTarget target;
  target.error = values.number("target_error");
  if (const auto budget = values.number("budget_ms")) target.seconds = 1e-3 * *budget;
  target.best_effort = values.flag("best_effort");
  target.only = given_representation(values);
  if (const auto text = values.text("brdf")) {
    try {
      target.brdf = parse_target_brdf(is_brdf_file(*text) ? path_beside(manifest, *text) : *text, "is");
    } catch (const Error& error) {
      table.refuse(table.has("brdf") ? "brdf" : "", error.what());
    }
  }
  if (has_target(values) && target.only && !target.brdf.can_shade(*target.only))
    table.refuse("", fmt::format("has ndf = \"{}\", which cannot shade the BRDF of its target",
                                 representation_info(*target.only).option));
  return target;
}

// Reports names that make_bake_jobs() would reject or misread, and their lines.
void check_paths(const StrictTable& table, const BakeJob& job) {
  const bool is_set = has_udim(job.input);
  if (is_set && !has_udim(fs::path(job.input).filename().string()))
    table.refuse("input", fmt::format("is \"{}\", expected <UDIM> in the file name, not in a folder name", job.input));
  if (!is_set && has_udim(job.output))
    table.refuse("output",
                 fmt::format("is \"{}\", but the input is not a set; expected a name without <UDIM>", job.output));
  for (const auto& [key, map] : kMaterialKeys)
    if (!is_set && has_udim(job.*map))
      table.refuse(
          table.has(key) ? key : "",
          fmt::format("has the {} \"{}\", but the input is not a set; expected a name without <UDIM>", key, job.*map));
  std::error_code error;
  const bool is_folder = is_set && !has_udim(job.output) && fs::is_directory(job.output, error);
  if (is_set && !has_udim(job.output) && !is_folder)
    table.refuse(
        "output",
        fmt::format("is \"{}\", which is one name for several maps; expected <UDIM> in it, or an existing folder",
                    job.output));
  if (!is_folder && !job.output.ends_with(".exr"))
    table.refuse("output", fmt::format("is \"{}\", expected a name that ends in .ndf.exr or .exr", job.output));
}

std::vector<BakeJob> jobs_of(const BakeJob& job) {
  if (!has_udim(job.input) || !find_tiles(job.input).empty()) return make_bake_jobs(job, {job.input});
  return {job};
}

// [defaults] may contain settings for fitting lobes, which apply to all maps with lobes. A map without lobes must not
// contain them.
void check_own_scopes(const StrictTable& table, const ParameterValues& values) {
  ParameterValues own = values;
  for (const Parameter& row : bake_parameters().rows())
    if (row.name != "ndf" && !table.has(row.name)) own.erase(row.name);
  const Parameter* const other = given_of_another_ndf(own);
  if (other == nullptr) return;
  const bool is_of_lobes = other->scope == ParameterScope::kLobes;
  table.refuse(
      table.has(other->name) ? other->name : "",
      fmt::format("works only with ndf = {}, found ndf = \"{}\"{}", is_of_lobes ? "\"vmf\" and \"gmm\"" : "\"sh\"",
                  values.text("ndf").value_or("vmf"), is_of_lobes ? ", which fits no lobes" : ""));
}

struct ManifestEntry {
  StrictTable table;
  std::vector<ManifestMap> maps;
};

ManifestEntry read_entry(const std::string& path, const toml::table& toml, const ParameterValues& defaults,
                         const BakeJob& pattern) {
  ManifestEntry entry{StrictTable(path, toml, "map", map_keys(), kWholeFile), {}};
  ParameterValues values = defaults;
  read_values(entry.table, values);
  check_own_scopes(entry.table, values);
  if (values.choice("surface", kMapSurfaces) == MapSurface::kInterpolated && values.integer("first_level") == 0)
    entry.table.refuse("first_level", "is 0 with surface = \"interpolated\", expected 1 or more");
  BakeJob job = pattern;
  apply(values, job);
  job.input = path_beside(path, entry.table.path("input"));
  job.output = path_beside(path, entry.table.path("output"));
  for (std::string BakeJob::*map : kMaterialMaps) job.*map = path_beside(path, job.*map);
  check_paths(entry.table, job);
  const BakeTarget target = target_of(entry.table, path, values);
  for (BakeJob& one : jobs_of(job)) {
    const std::string name = fs::path(one.output).lexically_proximate(fs::path(path).parent_path()).string();
    entry.maps.push_back(
        {name, std::move(one), values.number("error_max"), has_target(values) ? std::optional(target) : std::nullopt});
  }
  return entry;
}

// Compares names by means of a std::map and not pair by pair like check_paths_differ(), because a manifest may list
// thousands of maps.
void check_apart(const std::vector<ManifestEntry>& entries) {
  std::map<std::string, std::string> inputs, outputs;  // the use of each canonical name
  for (const ManifestEntry& entry : entries)
    for (const ManifestMap& map : entry.maps)
      for (const std::string& input : input_files(map.job))
        if (!input.empty()) inputs.emplace(canonical_name(input), input);
  for (const ManifestEntry& entry : entries)
    for (const ManifestMap& map : entry.maps) {
      const std::string name = canonical_name(map.job.output);
      if (const auto input = inputs.find(name); input != inputs.end())
        entry.table.refuse(
            "output", fmt::format("is \"{}\", which is also an input (read as {}); expected a different file", map.name,
                                  input->second));
      const auto [other, is_new] = outputs.emplace(name, map.job.input);
      if (!is_new)
        entry.table.refuse(
            "output", fmt::format("is \"{}\", which is already the output for {}; expected a different file", map.name,
                                  other->second));
    }
}

}  // namespace

std::vector<ManifestMap> read_bake_manifest(const std::string& path, const BakeJob& pattern) {
  const toml::table root = parse_toml(path, "a manifest as described in docs/reference/manifests.md");
  const StrictTable table(path, root, "", {"defaults", "map"}, kWholeFile);
  ParameterValues defaults(bake_parameters());
  const StrictTable of_all(path, table.table("defaults"), "defaults", default_keys(), kWholeFile);
  read_values(of_all, defaults);
  target_of(of_all, path, defaults);  // reports errors in [defaults]
  std::vector<ManifestEntry> entries;
  for (const toml::table* toml : table.tables("map")) entries.push_back(read_entry(path, *toml, defaults, pattern));
  check_apart(entries);
  std::vector<ManifestMap> maps;
  for (ManifestEntry& entry : entries)
    for (ManifestMap& map : entry.maps) maps.push_back(std::move(map));
  return maps;
}

}  // namespace multum
