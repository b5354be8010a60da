// SPDX-License-Identifier: Apache-2.0
// multum bake: options as maketx names them where it has them.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "host/bakes/bake/bake_batch.h"
#include "host/bakes/bake/bake_file.h"
#include "host/bakes/settings_search/chosen_bake.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/system_failure.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/bake_manifest_mode.h"
#include "tools/multum/bake_print.h"
#include "tools/multum/commands.h"
#include "tools/multum/openjd_lines.h"
#include "tools/multum/scene_mode.h"

namespace multum {
namespace {

struct BakeOptions {
  CommonOptions common;
  BakeJob job;
  ParameterValues values{bake_parameters()};
  ManifestModeOptions manifest;
  std::vector<std::string> inputs;
  std::string shard;  // of several maps, or of one; empty: all of it
  int merged_shards = 0;
};

std::optional<MapRegion> parse_region(const std::string& text) {
  if (text.empty() || text == "auto") return std::nullopt;
  MapRegion region;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", &region.x, &region.y, &region.width, &region.height, &rest) != 4)
    throw Error(ErrorCode::kUsage,
                "--region is '" + text + "', expected auto, or x,y,width,height in texels, e.g. 0,256,128,64");
  return region;
}

bool has_target(const BakeOptions& o) { return o.values.has("target_error") || o.values.has("budget_ms"); }

BakeTarget target_of(const BakeOptions& o) {
  BakeTarget target;
  target.error = o.values.number("target_error");
  if (const auto budget = o.values.number("budget_ms")) target.seconds = *budget / 1e3;
  target.brdf = parse_target_brdf(o.values.text("brdf").value_or(TargetBrdf().text));
  target.only = given_representation(o.values);
  target.best_effort = o.values.flag("best_effort");
  if (target.error) target.viewer.program = find_viewer();
  return target;
}

// Options that say what is to be chosen.
void check_target_options(const BakeOptions& o) {
  if (!has_target(o)) {
    if (o.values.has("brdf") || o.values.flag("best_effort"))
      throw Error(ErrorCode::kUsage, "--brdf and --best-effort need --target-error or --budget-ms, found neither");
    return;
  }
  if (const Parameter* chosen = given_of_target(o.values))
    throw Error(ErrorCode::kUsage,
                fmt::format("{} and {} exclude each other: a target chooses that setting", chosen->option(),
                            o.values.has("target_error") ? "--target-error" : "--budget-ms"));
}

BakePrinting printing(const BakeOptions& o) {
  return {o.common.quiet, o.values.flag("runstats") || o.common.verbose, stdout};
}

BakeReport bake_chosen(const BakeJob& job, const BakeOptions& o, Device& device) {
  const auto progress = make_progress(o.common);
  const ChosenBake chosen = bake_to_target(job, target_of(o), device, progress.get());
  if (chosen.written) print_report(job, printing(o), chosen.report);
  if (!chosen.met)
    throw Error(ErrorCode::kVerification,
                chosen.written ? job.input + ": no settings reach the target; the best are written"
                               : fmt::format("{}: no settings reach the target: {}--best-effort writes the best",
                                             job.input, chosen.report.choice));
  return chosen.report;
}

// Each map for itself: one that fails does not keep the others from their bake. The exit code is the first failure's.
int bake_several(const std::vector<BakeJob>& jobs, const BakeOptions& o, Device& device) {
  int code = 0;
  std::size_t unchanged = 0, failed = 0, begun = 0;
  for (const BakeJob& job : jobs) {
    openjd_part(begun++, jobs.size());
    try {
      if (has_target(o)) {
        unchanged += bake_chosen(job, o, device).unchanged ? 1 : 0;
        continue;
      }
      const auto progress = make_progress(o.common);
      const BakeReport report = bake_file(job, nullptr, device, progress.get());
      print_report(job, printing(o), report);
      unchanged += report.unchanged ? 1 : 0;
    } catch (...) {
      const Error error = caught_error(job.input);
      print_shown(stderr, "multum: %s\n", error.what());
      if (code == 0) code = exit_code(error.code());
      ++failed;
    }
  }
  if (!o.common.quiet || failed > 0)
    print_shown(failed > 0 ? stderr : stdout, "%zu maps: %zu baked, %zu unchanged, %zu failed\n", jobs.size(),
                jobs.size() - unchanged - failed, unchanged, failed);
  return code;
}

// The shares of one map are put together.
void check_merge(const BakeOptions& o, bool is_several) {
  if (o.merged_shards == 1) throw Error(ErrorCode::kUsage, "--merge is 1, expected 2 shares of one map, or more");
  if (is_several) throw Error(ErrorCode::kUsage, "--merge is given, expected one map: shares of several need no merge");
  if (has_target(o))
    throw Error(ErrorCode::kUsage, "--merge and a target exclude each other: shares have their settings");
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
  check_target_options(o);
  apply(o.values, job);
  const DeviceChoice device_choice{o.values.text("device").value_or(""), o.values.flag("scalar")};
  if (!o.shard.empty() && o.merged_shards > 0) throw Error(ErrorCode::kUsage, "--shard and --merge exclude each other");
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
  if (o.values.has("region") == job.onto.empty())
    throw Error(
        ErrorCode::kUsage,
        "--region and --onto need each other: the part that was edited, and the file that was baked before the edit");
  job.region = parse_region(o.values.text("region").value_or(""));
  std::vector<BakeJob> jobs = make_bake_jobs(job, o.inputs);
  const bool is_several = jobs.size() > 1;
  if (is_several && !o.shard.empty()) jobs = pieces_of(parse_work_shard("--shard", o.shard), std::move(jobs));
  else if (!o.shard.empty()) jobs[0].shard = parse_map_shard("--shard", o.shard);
  if (o.merged_shards > 0) {
    check_merge(o, is_several);
    jobs[0].merged_shards = o.merged_shards;
  }
  // One map is looked at first, which may end it; of several, none is read where there is no device to bake on.
  Device device = is_several ? Device::open(device_choice) : Device::when_needed(device_choice);
  device.time_launches(o.values.flag("runstats"));
  if (is_several) return bake_several(jobs, o, device);
  if (has_target(o)) return bake_chosen(jobs[0], o, device), 0;
  const auto progress = make_progress(o.common);
  print_report(jobs[0], printing(o), bake_file(jobs[0], nullptr, device, progress.get()));
  return 0;
}

}  // namespace

void add_bake_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<BakeOptions>();
  CLI::App* bake =
      app.add_subcommand("bake", "bake a normal map or height field into a mipmap of normal distributions");
  bake->add_option("input", options->inputs,
                   bake_parameters().at("input").help +
                       "; several maps, or sets, e.g. rock_<UDIM>.png; or a scene.toml, to bake only what it shows of "
                       "its maps into the folder --output (docs/reference/scenes.md)");
  bake->add_option("-o,--output", options->job.output,
                   "file to write, *.ndf.exr; for several maps: a folder, or a name with <UDIM>");
  bake->add_option(
      "--shard", options->shard,
      "bake share I of N of several maps or a scene alone, I/N, or shares I to J, I-J/N; of one map: 0/N its "
      "coarse levels, then 1/N to N/N, bands of the others: for farms (docs/how-to/clusters.md)");
  bake->add_option("--merge", options->merged_shards,
                   "write the file of one map from its shares 0/N to N/N; of a scene, check what shares 1/N to N/N "
                   "baked, and write its plan and report")
      ->type_name("N")
      ->check(CLI::Range(1, kMergedSharesMax));
  add_parameter_options(*bake, options->values);
  add_manifest_options(*bake, options->manifest);
  add_common_options(*bake, options->common);
  add_decoding_option(*bake);
  bake->callback([bake, options, exit_code] { *exit_code = run_bake(*bake, *options); });
}

}  // namespace multum
