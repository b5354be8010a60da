// SPDX-License-Identifier: Apache-2.0
// Implements multum tradeoff, which measures error, time and memory of many settings for one map on this machine.
#include <cstdio>
#include <memory>

#include "host/bakes/settings_search/tradeoff_page.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/brdf_families/brdf_forms.h"
#include "host/foundation/parameters/parameter_choices.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/commands.h"
#include "tools/multum/json_output.h"

namespace multum {
namespace {

struct TradeoffOptions {
  CommonOptions common;
  TradeoffJob job;
  ParameterValues values{bake_parameters()};
  std::optional<double> budget_ms, bake_ms_max;
  std::string brdf = TargetBrdf().text, output, report, markdown;
  bool quick = false, full = false, no_pictures = false;
};

// Returns the parameters for reading the map. The sweep sets the parameters of the bake.
std::vector<std::string> parameters_of_the_map() {
  std::vector<std::string> names = {"device"};
  for (const Parameter& row : bake_parameters().rows())
    if (row.group == kSourceGroup || row.group == kMaterialGroup) names.push_back(row.name);
  return names;
}

int run_tradeoff_command(TradeoffOptions& o) {
  TradeoffJob& job = o.job;
  job.bake.threads = job.bake.writing.threads = apply(o.common);
  keep_freed_memory();
  apply(o.values, job.bake);
  job.brdf = parse_target_brdf(o.brdf);
  if (job.has_roughness()) job.brdf.id = AccuracyBrdf::roughness();
  if (o.budget_ms) job.bake_seconds = *o.budget_ms / 1e3;
  if (o.bake_ms_max) job.bake_seconds_max = *o.bake_ms_max / 1e3;
  job.length = o.quick ? SweepLength::kQuick : o.full ? SweepLength::kFull : SweepLength::kDefault;
  if (!o.no_pictures) job.viewer = find_viewer();
  const std::vector<std::string> outputs = {o.output, o.report, o.markdown};
  check_paths_differ(input_files(job.bake), outputs);
  for (const std::string& path : outputs)
    if (!path.empty()) check_writable(path);
  job.output = o.output;
  Device device = Device::when_needed(DeviceChoice{o.values.text("device").value_or("")});
  const auto progress = make_progress(o.common);
  const TradeoffResult result = run_tradeoff(job, device, progress.get());
  write_text_file(o.output, tradeoff_page(job, result));
  if (!o.report.empty()) write_text_file(o.report, tradeoff_json(job, result));
  if (!o.markdown.empty()) write_text_file(o.markdown, tradeoff_markdown(result));
  if (o.common.json) print_json(parsed(tradeoff_json(job, result)));
  if (prints_text(o.common))
    print_shown(stdout, "%s: written, %zu settings in %.0f s\n%s", o.output.c_str(), result.setting_count(),
                result.seconds, tradeoff_text(job, result).c_str());
  const bool is_asked = job.error || job.bake_seconds || job.has_budget();
  return is_asked && !result.chosen ? exit_code(ErrorCode::kVerification) : 0;
}

}  // namespace

void add_tradeoff_command(CLI::App& app, int* exit_code) {
  auto o = std::make_shared<TradeoffOptions>();
  CLI::App* command = app.add_subcommand(
      "tradeoff", "bake a map with many settings, and write a page that compares their error, time and memory");
  command->add_option("input", o->job.bake.input, "normal map or height field")->required();
  command->add_option("-o,--output", o->output, "page to write, *.html; a single file with all pictures")->required();
  command->add_option("--report", o->report, "write all figures to this file as JSON");
  command->add_option("--markdown", o->markdown, "write the table to this file as Markdown");
  CLI::Option* error =
      command
          ->add_option("--target-error", o->job.error,
                       "choose the cheapest settings whose relative L1 error of pixels is at most this (0.1 means 10 "
                       "%)")
          ->check(CLI::PositiveNumber);
  command
      ->add_option("--budget-ms", o->budget_ms,
                   "choose the most accurate settings whose bake takes at most this many milliseconds")
      ->check(CLI::PositiveNumber)
      ->excludes(error);
  command
      ->add_option("--max-bytes", o->job.bytes_max,
                   "exclude settings that need more GPU memory than this size, such as 33M (33 MiB)")
      ->transform(CLI::AsSizeValue(false));
  command
      ->add_option("--max-frame-ms", o->job.frame_ms_max,
                   "exclude settings whose frame time is above this many "
                   "milliseconds")
      ->check(CLI::PositiveNumber);
  command
      ->add_option("--max-bake-ms", o->bake_ms_max,
                   "exclude settings whose bake time is above this many "
                   "milliseconds")
      ->check(CLI::PositiveNumber);
  CLI::Option* const brdf =
      command
          ->add_option("--brdf", o->brdf,
                       "measure errors with this BRDF: " + brdf_forms("") + " or the file of a measured BRDF")
          ->capture_default_str();
  CLI::Option* quick = command->add_flag("--quick", o->quick, "run about 12 bakes instead of about 40");
  command
      ->add_flag("--full", o->full,
                 "run about 65 bakes, with harmonics up to order 20 and longer fits for every number of lobes")
      ->excludes(quick);
  command->add_flag("--no-pictures", o->no_pictures,
                    "do not draw pictures; the page then lacks frame times and rendered errors");
  command->add_option("--context", o->job.context, "draw with this GL implementation: auto, osmesa (software) or egl")
      ->check(CLI::IsMember(choice_names(kContextBackends)))
      ->capture_default_str();
  add_parameter_options(*command, o->values, parameters_of_the_map());
  for (const char* option : {"--roughness", "--gloss"}) command->get_option(option)->excludes(brdf);
  add_decoding_option(*command, &o->job.decode);
  add_common_options(*command, o->common);
  command->footer(
      "Example:\n"
      "  multum tradeoff bricks_normal.png -o costs.html --max-bytes 33M\n"
      "All limits may be combined, also with --target-error. Without a target, the most accurate settings within\n"
      "the limits are chosen. Excluded settings are struck out.");
  command->callback([o, exit_code] { *exit_code = run_tradeoff_command(*o); });
}

}  // namespace multum
