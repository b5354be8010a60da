// SPDX-License-Identifier: Apache-2.0
// multum bake: options as maketx names them where it has them.
#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "host/bake/bake_batch.h"
#include "host/bake/bake_job.h"
#include "host/bake/chosen_bake.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/machine.h"
#include "host/base/shown_text.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum/bake_manifest_mode.h"
#include "tools/multum/bake_print.h"
#include "tools/multum/commands.h"
#include "tools/multum/map_options.h"
#include "tools/multum/scene_mode.h"

namespace multum {
namespace {

struct BakeOptions {
  CommonOptions common;
  BakeJob job;
  DeviceChoice device;
  MapOptions map;
  ManifestModeOptions manifest;
  std::vector<std::string> inputs;
  std::string region;
  std::optional<double> target_error, budget_ms;
  std::optional<std::string> brdf;
  bool best_effort = false;
  bool no_measure = false;
  bool run_stats = false;
};

void add_target_options(CLI::App& bake, BakeOptions& o) {
  CLI::Option* error = bake.add_option("--target-error", o.target_error,
                                       "choose the cheapest settings that come so near to the truth: relative L1, "
                                       "0.1 for 10 %, in the mean over levels 2 and up (a level may be worse); where "
                                       "none do, nothing is written and the exit code is 5");
  bake.add_option("--budget-ms", o.budget_ms,
                  "choose the most accurate settings that bake in so many milliseconds: reading, fitting and writing")
      ->excludes(error);
  bake.add_option("--brdf", o.brdf,
                  "of --target-error and --budget-ms: lambert, blinn-phong:S, ggx:ROUGHNESS, torrance-sparrow:SIGMA, "
                  "cook-torrance:SIGMA or a measured BRDF's file (default: blinn-phong:100)");
  bake.add_flag("--best-effort", o.best_effort,
                "of the two: write the best that was reached, too; the exit code stays 5");
  for (const char* option : {"--target-error", "--budget-ms", "--brdf", "--best-effort"})
    bake.get_option(option)->group(kMapOptionGroup);
}

void add_output_options(CLI::App& bake, BakeOptions& o) {
  bake.add_option("-o,--output", o.job.output,
                  "file to write, *.ndf.exr; of several maps: a folder, or a name with <UDIM>");
  bake.add_option("--report", o.job.report, "write times, counts and errors as JSON; of several maps: as --output");
  bake.add_option("--device", o.device.selector, "OpenCL device: a number of `multum devices` or part of a name");
  bake.add_flag("--scalar", o.device.as_accelerator,
                "work as on a GPU, with scalar kernels, teams of work-items and copies: same bytes, slower on CPUs");
  bake.add_option(
          "--memory", o.job.memory_bytes,
          "resident memory to stay within, as 800M or 2G: larger maps are baked in bands of rows, with the same "
          "result (default: what makes it faster, at most a quarter of the machine's)")
      ->transform(CLI::AsSizeValue(false));
  bake.add_option("--scratch", o.job.scratch_folder, "folder for what does not fit in memory (default: the output's)");
  bake.add_flag("--resume", o.job.resume, "go on from what a killed bake of the same output left beside it");
  bake.add_option("--region", o.region,
                  "x,y,width,height, or auto: only this part of the map was edited, or what is found to be; fit it "
                  "again and keep the rest of --onto");
  bake.add_option("--onto", o.job.onto, "the file that was baked before the edit; may be the output");
  bake.add_flag("--force", o.job.force, "bake even if the output is from the same file with the same settings");
  bake.add_flag("--no-measure", o.no_measure, "skip measuring the error of what is written");
  bake.add_flag("--runstats", o.run_stats, "print times, launches and numerical events");
}

std::optional<MapRegion> parse_region(const std::string& text) {
  if (text.empty() || text == "auto") return std::nullopt;
  MapRegion region;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%d,%d,%d,%d%c", &region.x, &region.y, &region.width, &region.height, &rest) != 4)
    throw Error(ErrorCode::kUsage,
                "--region is '" + text + "', expected auto, or x,y,width,height in texels, as 0,256,128,64");
  return region;
}

BakeReport bake_with_progress(const BakeJob& job, const BakeOptions& o, Device& device) {
  const auto progress = make_progress(o.common);
  return bake_file(job, device, progress.get());
}

bool has_target(const BakeOptions& o) { return o.target_error || o.budget_ms; }

BakeTarget target_of(const BakeOptions& o) {
  BakeTarget target;
  target.error = o.target_error;
  if (o.budget_ms) target.seconds = *o.budget_ms / 1e3;
  target.brdf = parse_target_brdf(o.brdf.value_or(TargetBrdf().name));
  target.only = o.map.ndf;
  target.best_effort = o.best_effort;
  return target;
}

// Options that say what is to be chosen.
void check_target_options(const BakeOptions& o) {
  if (!has_target(o)) {
    if (o.brdf || o.best_effort)
      throw Error(ErrorCode::kUsage, "--brdf and --best-effort are of --target-error and --budget-ms, found neither");
    return;
  }
  if (const char* option = option_of_target(o.map))
    throw Error(ErrorCode::kUsage, fmt::format("{} is chosen by {}: expected one of the two", option,
                                               o.target_error ? "--target-error" : "--budget-ms"));
}

BakePrinting printing(const BakeOptions& o) { return {o.common.quiet, o.run_stats || o.common.verbose, stdout}; }

BakeReport bake_chosen(const BakeJob& job, const BakeOptions& o, Device& device) {
  const auto progress = make_progress(o.common);
  const ChosenBake chosen = bake_to_target(job, target_of(o), device, progress.get());
  if (chosen.written) print_report(job, printing(o), chosen.report);
  if (!chosen.met)
    throw Error(ErrorCode::kVerification,
                chosen.written ? job.input + ": no settings reach it; the best is written all the same"
                               : fmt::format("{}: no settings reach it: {}--best-effort writes it all the same",
                                             job.input, chosen.report.choice));
  return chosen.report;
}

// Each map for itself: one that fails does not keep the others from their bake. The exit code is the first failure's.
int bake_several(const std::vector<BakeJob>& jobs, const BakeOptions& o, Device& device) {
  int code = 0;
  std::size_t unchanged = 0, failed = 0;
  for (const BakeJob& job : jobs) {
    try {
      if (has_target(o)) {
        unchanged += bake_chosen(job, o, device).unchanged ? 1 : 0;
        continue;
      }
      const BakeReport report = bake_with_progress(job, o, device);
      print_report(job, printing(o), report);
      unchanged += report.unchanged ? 1 : 0;
    } catch (const Error& error) {
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

int run_bake(const CLI::App& bake, BakeOptions& o) {
  BakeJob& job = o.job;
  const bool has_manifest = !o.manifest.manifest.empty();
  const bool has_scene = o.inputs.size() == 1 && o.inputs[0].ends_with(".toml");
  if (has_manifest) check_no_map_is_given(bake, o.manifest);
  else if (o.inputs.empty() || job.output.empty()) throw CLI::RequiredError(o.inputs.empty() ? "input" : "--output");
  if (has_scene) check_no_map_option_is_given(bake, o.inputs[0]);
  job.threads = job.writing.threads = apply(o.common);
  keep_freed_memory();
  if (has_manifest) return run_manifest(o.manifest, job, o.device, printing(o));
  if (has_scene) return run_scene(o.inputs[0], job, o.device, o.common, printing(o));
  check_options_of_ndf(o.map);
  check_target_options(o);
  apply(o.map, job);
  job.measure = !o.no_measure;
  if (o.region.empty() != job.onto.empty())
    throw Error(ErrorCode::kUsage,
                "--region and --onto go together: the part that was edited, and the file that was baked before");
  job.region = parse_region(o.region);
  const std::vector<BakeJob> jobs = make_bake_jobs(job, o.inputs);
  // One map is looked at first, which may end it; of several, none is read where there is no device to bake on.
  Device device = jobs.size() > 1 ? Device::open(o.device) : Device::when_needed(o.device);
  device.time_launches(o.run_stats);
  if (jobs.size() > 1) return bake_several(jobs, o, device);
  if (has_target(o)) return bake_chosen(jobs[0], o, device), 0;
  print_report(jobs[0], printing(o), bake_with_progress(jobs[0], o, device));
  return 0;
}

}  // namespace

void add_bake_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<BakeOptions>();
  CLI::App* bake =
      app.add_subcommand("bake", "bake a normal map or height field into a mipmap of normal distributions");
  bake->add_option(
      "input", options->inputs,
      "PNG, TIFF, EXR, JPEG or WebP, sides to 32768; several maps, or sets as rock_<UDIM>.png; or a scene.toml, "
      "of whose maps only what it shows is baked, into the folder --output (docs/SCENE.md)");
  add_output_options(*bake, *options);
  add_target_options(*bake, *options);
  add_manifest_options(*bake, options->manifest);
  add_common_options(*bake, options->common);
  add_decoding_option(*bake);
  add_map_options(*bake, options->map);
  bake->callback([bake, options, exit_code] { *exit_code = run_bake(*bake, *options); });
}

}  // namespace multum
