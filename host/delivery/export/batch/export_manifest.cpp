// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/batch/export_manifest.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "host/delivery/export/batch/export_batch.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/udim_set.h"
#include "host/foundation/parameters/export_parameters.h"
#include "host/foundation/toml/parameter_keys.h"
#include "host/foundation/toml/strict_toml.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kWholeFile[] = "the manifest";

std::vector<std::string> default_keys() {
  std::vector<std::string> keys = export_parameters().names(kInManifest);
  std::erase(keys, "input");
  return keys;
}

std::vector<std::string> map_keys() {
  std::vector<std::string> keys = export_parameters().names(kInManifest);
  keys.emplace_back("output");
  return keys;
}

// Rejects names that make_export_jobs() would reject. The error names the line.
void check_names(const StrictTable& table, const ExportJob& job) {
  const bool is_set = has_udim(job.input);
  if (is_set && !has_udim(fs::path(job.input).filename().string()))
    table.refuse("input", fmt::format("is \"{}\", expected <UDIM> in the file name, not in a folder name", job.input));
  if (is_set != has_udim(job.output))
    table.refuse("output", fmt::format("is \"{}\" although the input is {}; expected a name {} <UDIM>", job.output,
                                       is_set ? "a set" : "one map", is_set ? "with" : "without"));
  for (const std::string ExportJob::*beside : kExportMapsBeside)
    if (!is_set && has_udim(job.*beside))
      table.refuse(
          "", fmt::format("names \"{}\", but the input is not a set; expected a name without <UDIM>", job.*beside));
}

struct ManifestEntry {
  StrictTable table;
  std::vector<ManifestExport> maps;
};

ManifestEntry read_export_entry(const std::string& path, const toml::table& toml, const ParameterValues& defaults,
                                const ExportJob& pattern) {
  ManifestEntry entry{StrictTable(path, toml, "map", map_keys(), kWholeFile), {}};
  ParameterValues values = defaults;
  read_parameters(entry.table, kInManifest, values);
  ExportJob job = pattern;
  apply(values, job);
  job.input = path_beside(path, entry.table.path("input"));
  job.output = path_beside(path, entry.table.path("output"));
  for (std::string ExportJob::*beside : kExportMapsBeside) job.*beside = path_beside(path, job.*beside);
  check_names(entry.table, job);
  try {
    export_place(job.output);
  } catch (const Error& error) {
    entry.table.refuse("output", std::string("is ") + error.what());
  }
  // A set without tiles becomes one map, and reading this map fails later.
  const bool is_one = !has_udim(job.input) || find_tiles(job.input).empty();
  for (ExportJob& one : is_one ? std::vector<ExportJob>{job} : make_export_jobs(job, {job.input})) {
    const std::string name = fs::path(one.output).lexically_proximate(fs::path(path).parent_path()).string();
    entry.maps.push_back({name, std::move(one)});
  }
  return entry;
}

void check_places_differ(const std::vector<ManifestEntry>& entries) {
  std::map<std::string, std::string> records;  // record of an export -> map of the export
  for (const ManifestEntry& entry : entries)
    for (const ManifestExport& map : entry.maps) {
      const auto [other, is_new] = records.emplace(canonical_name(export_record_file(map.job)), map.job.input);
      if (!is_new)
        entry.table.refuse(
            "output",
            fmt::format("is \"{}\", which is already the output of {}; expected a different output for each map",
                        map.name, other->second));
    }
}

}  // namespace

std::vector<ManifestExport> read_export_manifest(const std::string& path, const ExportJob& pattern) {
  const toml::table root = parse_toml(path, "a manifest as described in docs/reference/manifests.md");
  const StrictTable table(path, root, "", {"defaults", "map"}, kWholeFile);
  ParameterValues defaults(export_parameters());
  const StrictTable of_all(path, table.table("defaults"), "defaults", default_keys(), kWholeFile);
  read_parameters(of_all, kInManifest, defaults);
  std::vector<ManifestEntry> entries;
  for (const toml::table* toml : table.tables("map"))
    entries.push_back(read_export_entry(path, *toml, defaults, pattern));
  check_places_differ(entries);
  std::vector<ManifestExport> maps;
  for (ManifestEntry& entry : entries)
    for (ManifestExport& map : entry.maps) maps.push_back(std::move(map));
  return maps;
}

ManifestExportResult run_manifest_export(const ManifestExport& map, bool is_dry, Device& device, Progress* progress) {
  ManifestExportResult result{find_export_state(map.job), std::nullopt};
  if (is_dry || (result.found.finding == ExportFinding::kInPlace && !map.job.force)) return result;
  result.report = export_file(map.job, device, progress);
  write_export_record(map.job, *result.report);
  return result;
}

}  // namespace multum
