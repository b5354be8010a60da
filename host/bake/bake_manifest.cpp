// SPDX-License-Identifier: Apache-2.0
// Maps are read one by one, each on top of [defaults], and only then set against one another: an output must be nobody
// else's, whichever of the two comes first.
#include "host/bake/bake_manifest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "host/bake/bake_batch.h"
#include "host/bake/map_options.h"
#include "host/bake/source_keys.h"
#include "host/bake/strict_toml.h"
#include "host/base/error.h"
#include "host/brdf/brdf_text.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kWhole[] = "the manifest";

const std::vector<std::string> kDefaultKeys = {
    "error_max",      "ndf",        "lobes",       "reference",   "iterations", "sweeps",       "order",
    "align",          "kappa_cap",  "first_level", "data_format", "wrap",       "swrap",        "twrap",
    "coarse_normals", "green",      "signed",      "unsigned",    "bumpformat", "height_scale", "two_channel",
    "no_rehearsal",   "sh_order",   "fixnan",      "checknan",    "repair_max", "albedo",       "compression",
    "normal_scale",   "roughness",  "gloss",       "weights",     "unaligned",  "target_error", "budget_ms",
    "brdf",           "best_effort"};

std::vector<std::string> map_keys() {
  std::vector<std::string> keys = kDefaultKeys;
  keys.insert(keys.end(), {"input", "output"});
  return keys;
}

// What [defaults] and a [[map]] may both say.
struct ManifestOptions {
  MapOptions map;
  std::optional<double> error_max;
  BakeTarget target;  // of an error, a time or nothing
  bool has_target() const { return target.error || target.seconds; }
};

void read_whole(const StrictTable& table, const std::string& key, const SettingRange<int>& range,
                std::optional<int>& value) {
  if (table.has(key)) value = table.whole(key, range.low, range.high);
}

NumberRange number_range(const SettingRange<float>& range) {
  return {static_cast<double>(range.low), static_cast<double>(range.high), false, false,
          fmt::format("a number from {} to {}", range.low, range.high)};
}

// The material's maps: keys and where they go.
constexpr std::pair<const char*, std::string BakeJob::*> kMaterialKeys[] = {
    {"albedo", &BakeJob::albedo}, {"roughness", &BakeJob::roughness}, {"weights", &BakeJob::weights}};

// Empty stays empty: no file.
std::string resolved(const std::string& manifest, const std::string& path) {
  return path.empty() ? "" : (fs::path(manifest).parent_path() / path).lexically_normal().string();
}

// What is said of a map itself goes before what is said of all: a target takes settings away, a setting the target.
void read_target(const StrictTable& table, const std::string& manifest, ManifestOptions& options) {
  BakeTarget& target = options.target;
  if (table.has("target_error") && table.has("budget_ms"))
    table.refuse("budget_ms", "is given beside target_error: expected one of them");
  if (table.has("target_error") || table.has("budget_ms")) {
    options.map = without_options_of_target(options.map);
    target.error.reset(), target.seconds.reset();
  }
  if (table.has("target_error"))
    target.error = table.number("target_error", {0.0, 2.0, true, false, "a number above 0, at most 2"}, 0.0);
  if (table.has("budget_ms")) target.seconds = 1e-3 * table.number("budget_ms", kAboveZero, 0.0);
  target.best_effort = table.boolean("best_effort", target.best_effort);
  if (!table.has("brdf")) return;
  const std::string text = table.text("brdf");
  try {
    target.brdf = parse_target_brdf(is_brdf_file(text) ? resolved(manifest, text) : text, "is");
  } catch (const Error& error) {
    table.refuse("brdf", error.what());
  }
}

void check_target_keys(const StrictTable& table, ManifestOptions& options) {
  if (const char* option = option_of_target(options.map); option != nullptr && options.has_target()) {
    std::string key = option + 2;  // "--sh-order"
    std::replace(key.begin(), key.end(), '-', '_');
    if (table.has("target_error") || table.has("budget_ms"))
      table.refuse(key, fmt::format("is chosen by {}: expected one of the two",
                                    table.has("target_error") ? "target_error" : "budget_ms"));
    options.target.error.reset(), options.target.seconds.reset();
  }
  for (const char* key : {"brdf", "best_effort"})
    if (table.has(key) && !options.has_target()) table.refuse(key, "is of target_error and budget_ms, found neither");
  if (options.has_target() && options.target.brdf.is_sum() && options.map.ndf == Representation::kGmm)
    table.refuse("", "has ndf = \"gmm\", which the BRDF of its target cannot be shaded with");
}

void read_options(const StrictTable& table, const std::string& manifest, ManifestOptions& options) {
  MapOptions& map = options.map;
  read_target(table, manifest, options);
  if (table.has("error_max")) options.error_max = table.number("error_max", kAboveZero, 0.0);
  read_source_keys(table, map);
  read_choice(table, "ndf", kNdfs, map.ndf);
  read_whole(table, "lobes", kLobeCounts, map.lobes);
  read_whole(table, "sh_order", {kShOrderMin, kShOrderMax}, map.sh_order);
  read_whole(table, "iterations", kIterationCounts, map.iterations);
  read_whole(table, "sweeps", kSweepCounts, map.sweeps);
  read_whole(table, "first_level", kFirstLevels, map.first_level);
  read_number(table, "align", number_range(kAlignments), map.alignment);
  read_number(table, "kappa_cap", number_range(kKappaCaps), map.kappa_cap);
  map.reference = table.boolean("reference", map.reference);
  map.no_rehearsal = table.boolean("no_rehearsal", map.no_rehearsal);
  map.unaligned = table.boolean("unaligned", map.unaligned);
  read_choice(table, "order", kFitOrders, map.order);
  read_choice(table, "coarse_normals", kCoarseNormals, map.coarse_normals);
  read_choice(table, "data_format", kStorageEncodings, map.data_format);
  if (table.has("compression")) map.compression = table.text("compression");
  if (map.compression && !is_compression(*map.compression))
    table.refuse("compression", fmt::format("is \"{}\", expected {}", *map.compression, kCompressionsInWords));
  check_target_keys(table, options);
}

// What make_bake_jobs() would refuse, and what it would take for a name, with the line.
void check_paths(const StrictTable& table, const BakeJob& job) {
  const bool is_set = has_udim(job.input);
  if (is_set && !has_udim(fs::path(job.input).filename().string()))
    table.refuse("input", fmt::format("is \"{}\", expected <UDIM> in the file's name, not in a folder's", job.input));
  if (!is_set && has_udim(job.output))
    table.refuse("output",
                 fmt::format("is \"{}\", but the input is no set: expected a name without <UDIM>", job.output));
  for (const auto& [key, map] : kMaterialKeys)
    if (!is_set && has_udim(job.*map))
      table.refuse(
          table.has(key) ? key : "",
          fmt::format("has the {} \"{}\", but the input is no set: expected a name without <UDIM>", key, job.*map));
  std::error_code error;
  const bool is_folder = is_set && !has_udim(job.output) && fs::is_directory(job.output, error);
  if (is_set && !has_udim(job.output) && !is_folder)
    table.refuse("output",
                 fmt::format("is \"{}\", one name for several maps: expected <UDIM> in it, or a folder that is there",
                             job.output));
  if (!is_folder && !job.output.ends_with(".exr"))
    table.refuse("output", fmt::format("is \"{}\", expected a name that ends in .ndf.exr or .exr", job.output));
}

std::vector<BakeJob> jobs_of(const BakeJob& job) {
  if (!has_udim(job.input) || !find_tiles(job.input).empty()) return make_bake_jobs(job, {job.input});
  return {job};
}

// [defaults] may say how lobes are fitted for all maps that have any; a map that has none may not.
void check_keys_of_ndf(const StrictTable& table, const MapOptions& map) {
  const Representation representation = map.ndf.value_or(Representation::kMovmf);
  if (table.has("sh_order") && representation != Representation::kSh)
    table.refuse("sh_order",
                 fmt::format("is for ndf = \"sh\", found ndf = \"{}\"", representation_info(representation).option));
  if (holds_lobes(representation)) return;
  for (const char* key : {"lobes", "iterations", "sweeps", "align", "kappa_cap", "reference", "no_rehearsal",
                          "unaligned", "order", "coarse_normals"})
    if (table.has(key))
      table.refuse(key, fmt::format("is for ndf = \"vmf\" and \"gmm\", found ndf = \"{}\", which fits no lobes",
                                    representation_info(representation).option));
}

struct ManifestEntry {
  StrictTable table;
  std::vector<ManifestMap> maps;
};

ManifestEntry read_entry(const std::string& path, const toml::table& toml, const ManifestOptions& defaults,
                         const BakeJob& pattern) {
  ManifestEntry entry{StrictTable(path, toml, "map", map_keys(), kWhole), {}};
  ManifestOptions options = defaults;
  read_options(entry.table, path, options);
  check_keys_of_ndf(entry.table, options.map);
  BakeJob job = pattern;
  apply(options.map, job);
  job.input = resolved(path, entry.table.text("input"));
  job.output = resolved(path, entry.table.text("output"));
  for (std::string BakeJob::*map : kMaterialMaps) job.*map = resolved(path, job.*map);
  check_paths(entry.table, job);
  for (BakeJob& one : jobs_of(job)) {
    const std::string name = fs::path(one.output).lexically_proximate(fs::path(path).parent_path()).string();
    options.target.only = options.map.ndf;
    entry.maps.push_back(
        {name, std::move(one), options.error_max, options.has_target() ? std::optional(options.target) : std::nullopt});
  }
  return entry;
}

// One name a file, however it is written.
std::string canonical(const std::string& path) {
  std::error_code none;
  return fs::weakly_canonical(fs::absolute(path, none), none).string();
}

// By names, not pair by pair as check_paths_differ() goes: a manifest may have thousands of maps.
void check_apart(const std::vector<ManifestEntry>& entries) {
  std::map<std::string, std::string> inputs, outputs;  // canonical name -> what it is
  for (const ManifestEntry& entry : entries)
    for (const ManifestMap& map : entry.maps)
      for (const std::string& input : input_files(map.job))
        if (!input.empty()) inputs.emplace(canonical(input), input);
  for (const ManifestEntry& entry : entries)
    for (const ManifestMap& map : entry.maps) {
      const std::string name = canonical(map.job.output);
      if (const auto input = inputs.find(name); input != inputs.end())
        entry.table.refuse("output", fmt::format("is \"{}\", which is read as {}: expected a file of its own", map.name,
                                                 input->second));
      const auto [other, is_new] = outputs.emplace(name, map.job.input);
      if (!is_new)
        entry.table.refuse("output", fmt::format("is \"{}\", where {} goes already: expected a file of its own",
                                                 map.name, other->second));
    }
}

}  // namespace

std::vector<ManifestMap> read_bake_manifest(const std::string& path, const BakeJob& pattern) {
  const toml::table root = parse_toml(path, "a manifest as docs/CI.md describes it");
  const StrictTable table(path, root, "", {"defaults", "map"}, kWhole);
  ManifestOptions defaults;
  read_options(StrictTable(path, table.table("defaults"), "defaults", kDefaultKeys, kWhole), path, defaults);
  std::vector<ManifestEntry> entries;
  for (const toml::table* toml : table.tables("map")) entries.push_back(read_entry(path, *toml, defaults, pattern));
  check_apart(entries);
  std::vector<ManifestMap> maps;
  for (ManifestEntry& entry : entries)
    for (ManifestMap& map : entry.maps) maps.push_back(std::move(map));
  return maps;
}

}  // namespace multum
