// SPDX-License-Identifier: Apache-2.0
// Implements multum plan, and multum bake for a scene.
#include "tools/multum/scene_mode.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "host/bakes/scene/scene_bake.h"
#include "host/bakes/scene/scene_share.h"
#include "host/formats/image/files/image_container.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/parameters/bake_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/openjd_lines.h"
#include "tools/multum/share_plan_mode.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr int kWidthDefault = 100;

// Returns the width of the terminal on stdout, or kWidthDefault.
int terminal_width() {
  winsize size{};
  return isatty(STDOUT_FILENO) != 0 && ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col
                                                                                                       : kWidthDefault;
}

struct PlanOptions {
  CommonOptions common;
  std::string scene, output;
  int width = 0;
  ParameterValues values{bake_parameters()};  // parameters of one map
  int shares = 0;
  double share_seconds = -1.0;
};

// Throws Error(kUsage) for an image, because many users try to plan an image at first.
void check_is_scene(const std::string& path) {
  if (!image_format(path).empty())
    throw Error(
        ErrorCode::kUsage,
        path +
            ": is an image, expected a scene.toml (docs/reference/scenes.md), or an image with --shards N for a farm "
            "(docs/how-to/clusters.md). To compare settings for one map: multum tradeoff " +
            path + " -o costs.html");
}

int run_plan(const CLI::App& plan_command, const PlanOptions& o) {
  if (o.shares > 0 || o.share_seconds >= 0.0) {
    apply(o.common);
    return run_share_plan({o.scene, o.values, o.shares, o.share_seconds, o.common.json});
  }
  check_is_scene(o.scene);
  check_no_map_option_is_given(plan_command, o.scene);
  add_key_words(bake_parameters().names(kInScene));
  BakeJob pattern;
  pattern.threads = pattern.writing.threads = apply(o.common);
  const SceneDescription scene = read_scene(o.scene, pattern);
  if (!o.output.empty()) check_writable(o.output);
  const auto progress = make_progress(o.common);
  PlanSettings settings;
  settings.threads = pattern.threads;
  settings.kept_bytes_max = 0;
  settings.for_bake = false;
  const ScenePlan plan = plan_scene(scene, settings, progress.get());
  progress_finish(progress.get());
  const fs::path folder = fs::path(o.output).parent_path();
  const auto json = [&] { return plan_json(scene, plan, {folder.empty() ? "." : folder.string()}); };
  if (!o.output.empty()) write_text_file(o.output, json_text(json(), 2) + "\n");
  if (o.common.json) print_json(json());
  else write_shown(stdout, plan_text(scene, plan, o.width > 0 ? o.width : terminal_width()));
  return 0;
}

// Throws Error(kUsage) if an output is also an input.
void check_outputs(const std::string& scene_file, const SceneDescription& scene, const SceneFiles& files) {
  std::vector<std::string> inputs = {scene_file}, outputs = {files.plan(), files.report()};
  for (const SceneMap& map : scene.maps) {
    for (const std::string& input : input_files(map.job)) inputs.push_back(input);
    outputs.push_back(files.folder + "/" + map.name + ".ndf.exr");
    outputs.push_back(files.folder + "/" + map.name + ".colours.exr");
  }
  check_paths_differ(inputs, outputs);
}

void print_map(const MapPlan& map, const SceneMapReport& report, const SceneFiles& files,
               const BakePrinting& printing) {
  BakeJob job = map.job;
  job.output = files.baked(map);
  print_report(job, printing, report.bake);
  if (report.has_colours && !printing.quiet)
    print_shown(printing.out, "%s: %s\n", files.colours(map).c_str(),
                report.colours.unchanged ? "unchanged" : "written");
}

// Prints the command that draws each object.
void print_views(const ScenePlan& plan, const SceneFiles& files, const BakePrinting& printing) {
  for (const ObjectPlan& object : plan.objects)
    print_shown(printing.out, "multum-view scene %s --object %s -o %s.png\n", files.plan().c_str(), object.name.c_str(),
                object.name.c_str());
}

int run_scene_shares(const SceneRun& run, const WorkShard& shares, const DeviceChoice& device_choice,
                     const CommonOptions& common, const SceneMapDone& done) {
  OrderedJson rows = OrderedJson::array();
  for (int i = shares.first; i <= shares.last; ++i) {
    openjd_part(static_cast<std::size_t>(i - shares.first), static_cast<std::size_t>(shares.last - shares.first + 1));
    const auto progress = make_progress(common);
    Device device = Device::when_needed(device_choice);
    const SceneShareReport report = bake_scene_share(run, i, shares.count, device, done, progress.get());
    progress_finish(progress.get());
    if (prints_text(common))
      print_shown(stdout, "share %d of %d: %d map%s, %s\n", i, shares.count, report.maps, report.maps == 1 ? "" : "s",
                  report.was_there ? "unchanged" : "written");
    rows.push_back({{"share", i}, {"of", shares.count}, {"maps", report.maps}, {"unchanged", report.was_there}});
  }
  if (common.json) print_json({{"shares", rows}});
  return 0;
}

int run_scene_merge(const SceneRun& run, int count, const CommonOptions& common, const BakePrinting& printing) {
  const auto progress = make_progress(common);
  const SceneReport report = merge_scene(run, count, progress.get());
  progress_finish(progress.get());
  if (common.json) print_json(report.to_json());
  if (printing.quiet) return 0;
  print_shown(printing.out, "%s: %zu maps of %d share%s\n", run.files.report().c_str(), report.maps.size(), count,
              count == 1 ? "" : "s");
  print_views(report.plan, run.files, printing);
  return 0;
}

}  // namespace

void check_no_map_option_is_given(const CLI::App& bake, const std::string& scene) {
  // The parameters that the command line sets for all maps at once.
  static const std::set<std::string> kOfTheScene = {"memory", "device", "scalar",  "scratch",
                                                    "force",  "resume", "runstats"};
  for (const CLI::Option* option : bake.get_options()) {
    if (option->count() == 0 || option->get_lnames().empty()) continue;
    std::string key = option->get_lnames().front();
    std::replace(key.begin(), key.end(), '-', '_');
    if (bake_parameters().find(key) != nullptr && !kOfTheScene.contains(key))
      throw Error(ErrorCode::kUsage, shown_name(*option) + " cannot be given with " + scene +
                                         ": the scene contains the settings of its maps");
  }
}

int run_scene(const std::string& scene_file, BakeJob pattern, const DeviceChoice& device_choice,
              const CommonOptions& common, const BakePrinting& printing, const SceneDivision& division) {
  add_key_words(bake_parameters().names(kInScene));
  SceneRun run;
  run.scene_file = scene_file;
  run.files = {pattern.output};
  run.force = pattern.force;
  pattern.output.clear();
  if (pattern.scratch_folder.empty()) pattern.scratch_folder = run.files.folder;
  run.planning.threads = pattern.threads;
  run.scene = read_scene(scene_file, pattern);
  check_outputs(scene_file, run.scene, run.files);
  make_folder(run.files.folder);
  const auto done = [&](const MapPlan& map, const SceneMapReport& report) {
    print_map(map, report, run.files, printing);
  };
  if (division.shares) return run_scene_shares(run, *division.shares, device_choice, common, done);
  if (division.merged_shards > 0) return run_scene_merge(run, division.merged_shards, common, printing);
  const auto progress = make_progress(common);
  const ScenePlan plan = plan_scene(run.scene, run.planning, progress.get());
  progress_finish(progress.get());
  if (!printing.quiet) write_shown(printing.out, plan_text(run.scene, plan, terminal_width()));
  Device device = Device::open(device_choice);
  const SceneReport report = bake_scene(run.scene, plan, run.files, device, done, progress.get());
  if (common.json) print_json(report.to_json());
  if (printing.quiet) return 0;
  write_shown(printing.out, report.to_text());
  print_views(plan, run.files, printing);
  return 0;
}

void add_plan_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<PlanOptions>();
  CLI::App* plan = app.add_subcommand(
      "plan", "list the effects that a scene needs from its maps, with reasons (docs/reference/scenes.md)");
  plan->footer(
      "Examples:\n"
      "  multum plan scene.toml\n"
      "  multum plan cliff.png --shards 8");
  plan->add_option("scene", options->scene,
                   "scene.toml, which lists maps, materials, objects, lights and the camera, "
                   "or one map")
      ->required();
  plan->add_option(
          "--shards", options->shares,
          "predict the processor time of one map's shares 0/N to N/N and of their merge (docs/how-to/clusters.md)")
      ->type_name("N")
      ->check(CLI::Range(2, 4096));
  plan->add_option("--share-seconds", options->share_seconds,
                   "divide one map into bands that take about this many seconds of processor time each; 0 does not "
                   "divide the map")
      ->check(CLI::NonNegativeNumber);
  plan->add_option("-o,--output", options->output, "write the plan as JSON to this file");
  plan->add_option("--width", options->width,
                   "set the width of the table in characters (default: the width of the terminal)")
      ->check(CLI::Range(60, 1000));
  add_decoding_option(*plan);
  add_common_options(*plan, options->common);
  // Adds the options of multum bake, because the shares of one map depend on the fit settings.
  add_parameter_options(*plan, options->values);
  plan->callback([plan, options, exit_code] { *exit_code = run_plan(*plan, *options); });
}

}  // namespace multum
