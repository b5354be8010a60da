// SPDX-License-Identifier: Apache-2.0
// Implements multum infer, which infers textures from ray-traced pictures (Hakura et al. 2000, section 3).
#include <cstdio>
#include <memory>
#include <optional>

#include "host/fields/inference/job/animation_job_reading.h"
#include "host/fields/inference/pipeline/inference_share.h"
#include "host/fields/inference/report/inference_run.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/base/shown_text.h"
#include "host/foundation/base/work_shard.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "tools/command_line/decoding_option.h"
#include "tools/command_line/parameter_options.h"
#include "tools/multum/fields/commands.h"
#include "tools/multum/json_output.h"
#include "tools/multum/openjd_lines.h"

namespace multum {
namespace {

struct InferOptions {
  CommonOptions common;
  InferenceRunSettings settings;
  ParameterValues values{infer_parameters()};
  std::string job;
  std::string shard;  // share to infer; empty to infer all textures
  int merged_shards = 0;
};

void print_results(const InferOptions& o, const InferenceReport& report) {
  int there = 0, written = 0;
  for (const TextureResult& texture : report.result.textures)
    if (!texture.file.empty()) (texture.was_there ? there : written) += 1;
  const StageSeconds& s = report.result.seconds;
  print_shown(stdout,
              "%s: %d textures written, %d already existed; mapping %.1f s, probing %.1f s, segmentation %.1f s, "
              "systems %.1f s, solving %.1f s, baseline %.1f s, frames %.1f s; %llu of %llu rows rejected\n",
              o.settings.inference.output.c_str(), written, there, s.mapping, s.probing, s.segmentation, s.systems,
              s.solving, s.baseline, s.rendering, static_cast<unsigned long long>(report.result.rows_rejected),
              static_cast<unsigned long long>(report.result.rows));
  print_shown(stdout, "%s%s/report.html: pictures and tables; report.json next to it has all figures\n",
              inference_report_text(report).c_str(), o.settings.inference.output.c_str());
}

void infer_shares(const InferOptions& o, const ParameterizedScene& field, const WorkShard& shares) {
  OrderedJson rows = OrderedJson::array();
  for (int i = shares.first; i <= shares.last; ++i) {
    openjd_part(static_cast<std::size_t>(i - shares.first), static_cast<std::size_t>(shares.last - shares.first + 1));
    const std::unique_ptr<Progress> progress = make_progress(o.common);
    const InferenceShareResult result = infer_share(field, o.settings.inference, {i, shares.count}, progress.get());
    progress_finish(progress.get());
    if (prints_text(o.common))
      print_shown(stdout, "share %d of %d: %d texture%s, %s\n", i, shares.count, result.textures,
                  result.textures == 1 ? "" : "s", result.was_there ? "unchanged" : "written");
    rows.push_back(
        {{"share", i}, {"of", shares.count}, {"textures", result.textures}, {"unchanged", result.was_there}});
  }
  if (o.common.json) print_json({{"shares", rows}});
}

int run_infer(InferOptions& o) {
  o.settings.inference.threads = apply(o.common);
  apply(o.values, o.settings);
  o.settings.inference.viewer = find_viewer();
  std::optional<WorkShard> shares;
  if (!o.shard.empty()) shares = parse_merged_shard("--shard", o.shard);
  if (shares && o.merged_shards > 0) throw Error(ErrorCode::kUsage, "--shard and --merge are mutually exclusive");
  const std::unique_ptr<Progress> progress = make_progress(o.common);
  const ParameterizedScene field(read_animation_job(o.job));
  make_folder(o.settings.inference.output);
  if (shares) return infer_shares(o, field, *shares), 0;
  InferenceRun run;
  run_inference(field, o.settings, o.merged_shards, progress.get(), run);
  progress_finish(progress.get());
  const InferenceReport report = run.report(field, o.settings);
  if (o.common.json) print_json(parsed(inference_report_json(report)));
  if (prints_text(o.common)) print_results(o, report);
  return 0;
}

}  // namespace

void add_infer_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<InferOptions>();
  InferOptions& o = *options;
  CLI::App* infer =
      app.add_subcommand("infer", "infer textures from ray-traced pictures (docs/reference/animation_jobs.md)");
  infer->footer("Example:\n  multum infer animation.toml -o inferred");
  infer->add_option("job", o.job, infer_parameters().at("job").help)->required();
  infer->add_option("-o,--output", o.settings.inference.output, "folder for textures, matrices, manifest and report")
      ->required();
  infer->add_option("--shard", o.shard,
                    "infer only the textures of share I of N (I/N), or of shares I to J (I-J/N); all shares have the "
                    "same output folder");
  infer
      ->add_option("--merge", o.merged_shards,
                   "check the textures of shares 1/N to N/N, and write the manifest, the frames and the report")
      ->type_name("N")
      ->check(CLI::Range(1, kMergedSharesMax));
  add_parameter_options(*infer, o.values);
  add_common_options(*infer, o.common);
  add_decoding_option(*infer);
  infer->callback([options, exit_code] { *exit_code = run_infer(*options); });
}

}  // namespace multum
