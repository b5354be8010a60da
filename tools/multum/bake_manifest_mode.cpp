// SPDX-License-Identifier: Apache-2.0
#include "tools/multum/bake_manifest_mode.h"

#include <algorithm>
#include <utility>

#include "host/bakes/bake/bake_file.h"
#include "host/bakes/manifest/manifest_report.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/stopwatch.h"
#include "host/foundation/base/system_failure.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/check/verdict_line.h"
#include "tools/multum/map_turns.h"

namespace multum {
namespace {

constexpr char kStdout[] = "-";

// Checks the names of result files before any work. Otherwise a long run could end with a report that cannot be written
// or that overwrites a map.
void check_result_files(const ManifestModeOptions& o, const std::vector<ManifestMap>& maps) {
  std::vector<std::string> taken = {o.manifest};
  for (const ManifestMap& map : maps) {
    for (const std::string& file : input_files(map.job)) taken.push_back(file);
    taken.push_back(map.job.output);
  }
  const std::string summary = o.summary == kStdout ? "" : o.summary;
  check_paths_differ(taken, {o.junit, summary});
  for (const std::string& file : {o.junit, summary})
    if (!file.empty()) check_writable(file);
}

void print_result(const ManifestMap& map, const BakePrinting& printing, const MapResult& result, bool is_check,
                  std::FILE* err) {
  if (result.state == MapState::kFailed) print_shown(err, "multum: %s\n", result.why.c_str());
  if (result.report) {
    print_report(map.job, printing, *result.report);
  } else if (result.state == MapState::kUnchanged && !is_check) {
    BakeReport unchanged;
    unchanged.unchanged = true;
    print_report(map.job, printing, unchanged);
  } else if (result.state == MapState::kUnchanged && !printing.quiet) {
    print_shown(printing.out, "%s: in place, error at most %.4g %%, as the file states\n", map.job.output.c_str(),
                100.0 * result.error.value_or(0.0));
  }
}

struct MapOutcome {
  MapResult result;
  std::optional<GainVerdict> gain;  // set if the map was baked
};

// Bakes or checks one map. If it fails, the other maps are still handled.
MapOutcome run_map(ManifestMap map, const ManifestModeOptions& o, const CommonOptions& common,
                   const BakePrinting& printing, const MapTurn& turn) {
  map.job.threads = map.job.writing.threads = turn.threads;
  const Stopwatch stopwatch;
  MapResult result;
  try {
    result = run_manifest_map(map, o.run, turn.device, turn.progress);
  } catch (...) {
    result = failed_map(map, caught_error(map.job.input));
  }
  result.seconds = stopwatch.seconds();
  print_result(map, printing, result, o.run.check, turn.err);
  if (!result.report) return {result, std::nullopt};
  const std::optional<GainVerdict> gain = end_with_verdict(map.job, *result.report, common, turn.device, printing.out);
  result.report->mosaic.reset();  // all results stay in memory until the run ends
  result.report->starts.reset();
  return {result, gain};
}

// Returns the number of maps that are handled at the same time. A map with a target uses all processors on its own, and
// --runstats and --verbose print times, which have a meaning only if no other map is baked. A GPU is not shared.
int maps_at_once(std::vector<ManifestMap>& maps, const BakePrinting& printing, const Device& device) {
  const auto has_target = [](const ManifestMap& map) { return map.target.has_value(); };
  if (maps.empty() || printing.details || !device.info().is_cpu || std::any_of(maps.begin(), maps.end(), has_target))
    return 1;
  std::vector<BakeJob*> jobs;
  for (ManifestMap& map : maps) jobs.push_back(&map.job);
  return share_memory(jobs);
}

OrderedJson map_json(const ManifestMap& map, const MapResult& result, const std::optional<GainVerdict>& gain) {
  OrderedJson json = {{"name", result.name}, {"state", map_state_name(result.state)}};
  if (!result.why.empty()) json["why"] = result.why;
  for (const auto& [key, value] : {std::pair{"error", &result.error}, std::pair{"stated_error", &result.stated},
                                   std::pair{"allowed_error", &result.allowed}})
    if (*value) json[key] = **value;
  json["seconds"] = result.seconds;
  json["bytes"] = result.bytes;
  if (result.report) json["report"] = with_verdict(bake_json(map.job, *result.report), gain);
  return json;
}

OrderedJson outcome_json(const ManifestOutcome& outcome, const std::vector<ManifestMap>& maps,
                         const std::vector<std::optional<GainVerdict>>& gains) {
  OrderedJson json = {{"manifest", path_json(outcome.manifest)},
                      {"passed", manifest_exit_code(outcome) == 0},
                      {"seconds", outcome.seconds},
                      {"maps", OrderedJson::array()}};
  for (std::size_t i = 0; i < maps.size(); ++i) json["maps"].push_back(map_json(maps[i], outcome.results[i], gains[i]));
  return json;
}

void print_outcome(const ManifestOutcome& outcome, const BakePrinting& printing) {
  const std::string failures = manifest_failures(outcome);
  write_shown(stderr, failures);
  if (failures.empty() && !printing.quiet) print_shown(printing.out, "%s\n", manifest_verdict(outcome).c_str());
}

}  // namespace

void add_manifest_options(CLI::App& bake, ManifestModeOptions& o) {
  CLI::Option* const manifest = bake.add_option("--manifest", o.manifest,
                                                "bake the changed maps in this maps.toml; this option replaces the "
                                                "input and --output");
  CLI::Option* const check = bake.add_flag("--check", o.run.check,
                                           "also verify and measure existing files; exit with code 5 if a file was "
                                           "missing, stale or damaged, or if its error exceeds its stated error or "
                                           "error_max")
                                 ->needs(manifest);
  bake.add_flag("--dry-run", o.run.dry_run, "with --check, list the findings, but bake nothing")->needs(check);
  bake.add_option("--junit", o.junit, "write the findings to this file as JUnit XML")->needs(manifest);
  bake.add_option("--summary", o.summary, "write the findings as a Markdown table to this file, or to stdout for -")
      ->needs(manifest);
  check->excludes("--force");
}

void check_no_map_is_given(const CLI::App& bake, const ManifestModeOptions& o) {
  static const std::vector<std::string> kOfNamedMaps = {"input",    "--output", "--report",
                                                        "--region", "--onto",   "--no-measure"};
  for (const CLI::Option* option : bake.get_options()) {
    if (option->count() == 0) continue;
    const std::string name = shown_name(*option);
    if (std::find(kOfNamedMaps.begin(), kOfNamedMaps.end(), name) != kOfNamedMaps.end())
      throw Error(ErrorCode::kUsage,
                  name + " and --manifest are mutually exclusive, because the manifest names the maps");
    std::string key = option->get_lnames().empty() ? name : option->get_lnames().front();
    std::replace(key.begin(), key.end(), '-', '_');
    const Parameter* const parameter = bake_parameters().find(key);
    if (parameter == nullptr || !parameter->is_on(kInManifest)) continue;
    throw Error(ErrorCode::kUsage, name + " and --manifest are mutually exclusive, expected " + parameter->name +
                                       " under [[map]] or [defaults] in " + o.manifest);
  }
}

int run_manifest(const ManifestModeOptions& o, const BakeJob& pattern, const DeviceChoice& device_choice,
                 const CommonOptions& common, BakePrinting printing) {
  const Stopwatch stopwatch;
  add_key_words(bake_parameters().names(kInManifest));
  if (o.summary == kStdout && common.json)
    throw Error(ErrorCode::kUsage, "--summary - and --json are mutually exclusive, because both print to stdout");
  if (o.summary == kStdout) printing.out = stderr;
  std::vector<ManifestMap> maps = read_bake_manifest(o.manifest, pattern);
  check_result_files(o, maps);
  maps = pieces_of(o.shard, std::move(maps));
  Device device = Device::open(device_choice);
  ManifestOutcome outcome{o.manifest, o.run, std::vector<MapResult>(maps.size()), 0.0};
  std::vector<std::optional<GainVerdict>> gains(maps.size());
  const MapTurns turns{maps.size(), maps_at_once(maps, printing, device), pattern.threads, device_choice};
  for_each_map(turns, common, device, [&](const MapTurn& turn) {
    BakePrinting shown = printing;
    shown.out = printing.out == stdout ? turn.out : turn.err;
    MapOutcome made = run_map(maps[turn.map], o, common, shown, turn);
    outcome.results[turn.map] = std::move(made.result);
    gains[turn.map] = std::move(made.gain);
  });
  outcome.seconds = stopwatch.seconds();
  print_outcome(outcome, printing);
  if (!o.junit.empty()) write_text_file(o.junit, manifest_junit(outcome));
  if (o.summary == kStdout) write_shown(stdout, manifest_summary(outcome));
  else if (!o.summary.empty()) write_text_file(o.summary, manifest_summary(outcome));
  if (common.json) print_json(outcome_json(outcome, maps, gains));
  return manifest_exit_code(outcome);
}

}  // namespace multum
