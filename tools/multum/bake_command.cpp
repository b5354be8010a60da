// SPDX-License-Identifier: Apache-2.0
// Implements multum bake. Options that also exist in maketx have the same names as in maketx.
#include <cstdio>
#include <memory>
#include <utility>

#include "host/bakes/bake/bake_batch.h"
#include "host/bakes/bake/bake_file.h"
#include "host/bakes/bake/job_parameters.h"
#include "host/bakes/settings_search/chosen_bake.h"
#include "host/bakes/settings_search/target_parameters.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/system_failure.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/bake_manifest_mode.h"
#include "tools/multum/bake_print.h"
#include "tools/multum/check/verdict_line.h"
#include "tools/multum/commands.h"
#include "tools/multum/map_turns.h"
#include "tools/multum/scene_mode.h"

namespace multum {
namespace {

struct BakeOptions {
  CommonOptions common;
  BakeJob job;
  ParameterValues values{bake_parameters()};
  ManifestModeOptions manifest;
  std::vector<std::string> inputs;
  std::string shard;  // shares of several maps or of one map; empty to bake everything
  int merged_shards = 0;
};

BakePrinting printing(const BakeOptions& o) {
  return {!prints_text(o.common), o.values.flag("runstats") || o.common.verbose, stdout, o.common.json};
}

BakeReport bake_and_print(const BakeJob& job, const BakeOptions& o, Device& device, Progress* progress,
                          const BakePrinting& shown) {
  if (!has_target(o.values)) {
    BakeReport report = bake_file(job, nullptr, device, progress);
    print_report(job, shown, report);
    return report;
  }
  const ChosenBake chosen = bake_to_target(job, bake_target(o.values, find_viewer()), device, progress);
  if (chosen.written) print_report(job, shown, chosen.report);
  check_met(job, chosen);
  return chosen.report;
}

// The result of one of several maps.
struct BakedMap {
  OrderedJson json;
  bool unchanged = false;
  int failure = 0;  // exit code
};

// Bakes one of several maps. If it fails, the others are still baked.
BakedMap bake_one(BakeJob job, const BakeOptions& o, const MapTurn& turn) {
  job.threads = job.writing.threads = turn.threads;
  BakePrinting shown = printing(o);
  shown.out = turn.out;
  try {
    const BakeReport report = bake_and_print(job, o, turn.device, turn.progress, shown);
    return {with_verdict(bake_json(job, report), end_with_verdict(job, report, o.common, turn.device, turn.out)),
            report.unchanged};
  } catch (...) {
    const Error error = caught_error(job.input);
    print_shown(turn.err, "multum: %s\n", error.what());
    return {failed_bake_json(job, error.what()), false, exit_code(error.code())};
  }
}

// Returns the number of maps that are baked at the same time. With a target, all processors try settings for one map,
// and times of launches and stages have a meaning only if no other map is baked. A GPU is not shared.
int maps_at_once(std::vector<BakeJob>& jobs, const BakeOptions& o, const Device& device) {
  if (jobs.empty() || has_target(o.values) || printing(o).details || !device.info().is_cpu) return 1;
  std::vector<BakeJob*> all;
  for (BakeJob& job : jobs) all.push_back(&job);
  return share_memory(all);
}

// Returns the exit code of the first failure.
int bake_several(std::vector<BakeJob> jobs, const BakeOptions& o, const DeviceChoice& choice, Device& device) {
  std::vector<BakedMap> results(jobs.size());
  const MapTurns turns{jobs.size(), maps_at_once(jobs, o, device), jobs.empty() ? 1 : jobs.front().threads, choice};
  for_each_map(turns, o.common, device,
               [&](const MapTurn& turn) { results[turn.map] = bake_one(jobs[turn.map], o, turn); });
  int code = 0;
  std::size_t unchanged = 0, failed = 0;
  OrderedJson maps = OrderedJson::array();
  for (BakedMap& result : results) {
    unchanged += result.unchanged ? 1 : 0;
    failed += result.failure != 0 ? 1 : 0;
    if (code == 0) code = result.failure;
    maps.push_back(std::move(result.json));
  }
  if (prints_text(o.common) || failed > 0)
    print_shown(failed > 0 ? stderr : stdout, "%zu maps: %zu baked, %zu unchanged, %zu failed\n", jobs.size(),
                jobs.size() - unchanged - failed, unchanged, failed);
  if (o.common.json) print_json({{"maps", maps}});
  return code;
}

// Throws Error(kUsage) if --merge does not name shares of one map.
void check_merge(const BakeOptions& o, bool is_several) {
  if (o.merged_shards == 1) throw Error(ErrorCode::kUsage, "--merge is 1, expected at least 2 shares of one map");
  if (is_several)
    throw Error(ErrorCode::kUsage,
                "found --merge for several maps, expected one map, because shares of several maps need no merge");
  if (has_target(o.values))
    throw Error(ErrorCode::kUsage,
                "--merge and a target are mutually exclusive, because the shares already have their settings");
}

int run_bake(const CLI::App& bake, BakeOptions& o) {
  BakeJob& job = o.job;
  const bool has_manifest = !o.manifest.manifest.empty();
  const bool has_scene = o.inputs.size() == 1 && o.inputs[0].ends_with(".toml");
  if (has_manifest) check_no_map_is_given(bake, o.manifest);
  else if (o.inputs.empty() || job.output.empty()) throw CLI::RequiredError(o.inputs.empty() ? "input" : "--output");
  if (has_scene) check_no_map_option_is_given(bake, o.inputs[0]);
  job.threads = job.writing.threads = apply(o.common);
  keep_freed_memory();
  check_scopes(o.values);
  check_target_values(o.values);
  apply(o.values, job);
  // The plan of a scene says what each object gains, and a scene fits only what it needs.
  job.keeps_mosaic = job.measure && !o.common.quiet && !has_scene;
  const DeviceChoice device_choice{o.values.text("device").value_or(""), o.values.flag("scalar")};
  if (!o.shard.empty() && o.merged_shards > 0)
    throw Error(ErrorCode::kUsage, "--shard and --merge are mutually exclusive");
  if (has_manifest) {
    if (o.merged_shards > 0) check_merge(o, true);
    if (!o.shard.empty()) o.manifest.shard = parse_work_shard("--shard", o.shard);
    return run_manifest(o.manifest, job, device_choice, o.common, printing(o));
  }
  if (has_scene) {
    SceneDivision division;
    if (!o.shard.empty()) division.shares = parse_merged_shard("--shard", o.shard);
    division.merged_shards = o.merged_shards;
    return run_scene(o.inputs[0], job, device_choice, o.common, printing(o), division);
  }
  apply_region(o.values, job);
  std::vector<BakeJob> jobs = make_bake_jobs(job, o.inputs);
  const bool is_several = jobs.size() > 1;
  if (is_several && !o.shard.empty()) jobs = pieces_of(parse_work_shard("--shard", o.shard), std::move(jobs));
  else if (!o.shard.empty()) jobs[0].shard = parse_map_shard("--shard", o.shard);
  if (o.merged_shards > 0) {
    check_merge(o, is_several);
    jobs[0].merged_shards = o.merged_shards;
  }
  // A single map is checked before the device is opened. Several maps are read only after the device has been opened.
  Device device = is_several ? Device::open(device_choice) : Device::when_needed(device_choice);
  device.time_launches(o.values.flag("runstats"));
  if (is_several) return bake_several(std::move(jobs), o, device_choice, device);
  const auto progress = make_progress(o.common);
  const BakeReport report = bake_and_print(jobs[0], o, device, progress.get(), printing(o));
  const std::optional<GainVerdict> verdict = end_with_verdict(jobs[0], report, o.common, device);
  if (o.common.json) print_json(with_verdict(bake_json(jobs[0], report), verdict));
  return 0;
}

}  // namespace

void add_bake_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<BakeOptions>();
  CLI::App* bake = app.add_subcommand("bake", "bake normal maps or height fields into mipmaps of normal distributions");
  bake->add_option("input", options->inputs,
                   bake_parameters().at("input").help +
                       "; also several maps, a tile set such as rock_<UDIM>.png, or one scene.toml");
  bake->add_option("-o,--output", options->job.output,
                   "output file, *.ndf.exr; for several maps, a folder or a name with <UDIM>; for a scene, a folder");
  bake->add_option("--shard", options->shard,
                   "bake only share I of N (I/N), or shares I to J (I-J/N), of several maps or a scene; for one map, "
                   "share 0/N contains the coarse levels, and shares 1/N to N/N contain bands of rows");
  bake->add_option("--merge", options->merged_shards,
                   "merge shares 0/N to N/N of one map into its file; for a scene, check shares 1/N to N/N, and write "
                   "the plan and report")
      ->type_name("N")
      ->check(CLI::Range(1, kMergedSharesMax));
  add_parameter_options(*bake, options->values);
  add_manifest_options(*bake, options->manifest);
  add_common_options(*bake, options->common);
  add_decoding_option(*bake);
  bake->footer(
      "Examples:\n"
      "  multum bake bricks_n.png -o bricks.ndf.exr\n"
      "  multum bake 'rock_<UDIM>.png' -o 'rock_<UDIM>.ndf.exr'     # all tiles of a set\n"
      "  multum bake --manifest maps.toml --check                   # the changed maps of a project\n"
      "  multum bake scene.toml -o baked                            # only what a scene shows of its maps\n"
      "If one map fails, the other maps are still baked. Shares are files next to the output. With --region, texels\n"
      "outside of the region keep their lobes, so the checksum differs from a full bake. Scratch files need about\n"
      "40 bytes per texel with four lobes. More: docs/reference/input_maps.md, docs/reference/manifests.md,\n"
      "docs/reference/scenes.md and docs/how-to/clusters.md.");
  bake->callback([bake, options, exit_code] { *exit_code = run_bake(*bake, *options); });
}

}  // namespace multum
