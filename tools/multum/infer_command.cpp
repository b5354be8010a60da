// SPDX-License-Identifier: Apache-2.0
// multum infer: textures from ray-traced pictures (Hakura et al. 2000, section 3).
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numeric>

#include "host/bake/animation_infer.h"
#include "host/bake/animation_job_reading.h"
#include "host/bake/inference_comparison.h"
#include "host/bake/inference_frames.h"
#include "host/bake/inference_page.h"
#include "host/base/error.h"
#include "host/base/log.h"
#include "host/base/machine.h"
#include "host/base/output_paths.h"
#include "host/base/shown_text.h"
#include "tools/command_line/decoding_option.h"
#include "tools/multum/commands.h"

namespace multum {
namespace {

struct InferOptions {
  CommonOptions common;
  AnimationInferSettings settings;
  std::string job;
  std::string report_sample;  // empty: the middle one
  bool no_frames = false;
  bool no_comparison = false;
};

std::vector<int> all_samples(const AnimationJob& job) {
  std::vector<int> samples(job.samples.size());
  std::iota(samples.begin(), samples.end(), 0);
  return samples;
}

void print_results(const InferOptions& o, const InferenceReport& report) {
  int there = 0, written = 0;
  for (const TextureResult& texture : report.result.textures)
    if (!texture.file.empty()) (texture.was_there ? there : written) += 1;
  const StageSeconds& s = report.result.seconds;
  print_shown(stdout,
              "%s: %d textures written, %d there already; mapping %.1f s, probing %.1f s, segmentation %.1f s, "
              "systems %.1f s, solving %.1f s, baseline %.1f s, frames %.1f s; %llu of %llu rows rejected\n",
              o.settings.output.c_str(), written, there, s.mapping, s.probing, s.segmentation, s.systems, s.solving,
              s.baseline, s.rendering, static_cast<unsigned long long>(report.result.rows_rejected),
              static_cast<unsigned long long>(report.result.rows));
  print_shown(stdout, "%s%s/report.html: pictures and tables; report.json beside it has every figure\n",
              inference_report_text(report).c_str(), o.settings.output.c_str());
}

int run_infer(InferOptions& o) {
  o.settings.threads = apply(o.common);
  o.settings.viewer = find_viewer();
  const std::unique_ptr<Progress> progress = make_progress(o.common);
  const AnimationField field(read_animation_job(o.job));
  make_folder(o.settings.output);
  const int sample = o.report_sample.empty() ? middle_sample(field.job()) : sample_named(field.job(), o.report_sample);
  AnimationInferResult result = infer_animation(field, o.settings, progress.get());
  InferenceFrames frames;
  if (!o.no_frames) {
    frames = render_frames(field, {o.settings.output, o.settings.viewer, o.settings.context}, all_samples(field.job()),
                           progress.get());
    result.seconds.rendering = frames.seconds;
  }
  InferenceComparison comparison;
  if (!o.no_comparison) comparison = compare_inference(field, sample, result.mappings, o.settings, progress.get());
  progress_finish(progress.get());
  const InferenceReport report = {field.job(),
                                  o.settings,
                                  result,
                                  sample,
                                  o.no_frames ? nullptr : &frames,
                                  o.no_comparison ? nullptr : &comparison};
  write_inference_report(field, report);
  if (!o.common.quiet) print_results(o, report);
  return 0;
}

}  // namespace

std::string find_viewer() {
  std::error_code error;
  const std::string beside = own_folder() + "/multum-view";
  return std::filesystem::exists(beside, error) ? beside : "multum-view";
}

void add_infer_command(CLI::App& app, int* exit_code) {
  auto options = std::make_shared<InferOptions>();
  InferOptions& o = *options;
  CLI::App* infer = app.add_subcommand("infer", "infer textures from ray-traced pictures (docs/ANIMATION.md)");
  infer->add_option("job", o.job, "animation.toml, as `multum animation` writes it")->required();
  infer->add_option("-o,--output", o.settings.output, "folder for textures, matrices, manifest and report")->required();
  infer->add_option("--device", o.settings.device, "OpenCL device: a number of `multum devices` or part of a name");
  infer->add_option("--context", o.settings.context, "GL to infer for: auto, osmesa (software) or egl")
      ->check(CLI::IsMember({"auto", "osmesa", "egl"}))
      ->capture_default_str();
  infer->add_option("--tolerance", o.settings.gradient_tolerance, "relative gradient at which a texture is solved")
      ->check(CLI::Range(1e-7, 1.0))
      ->capture_default_str();
  infer->add_option("--iterations", o.settings.iteration_max, "of conjugate gradient a texture, at most")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  infer
      ->add_option("--hold-out", o.settings.hold_out,
                   "leave every Nth view out of layers that do not depend on views, and report the error there")
      ->check(CLI::Range(2, 1000));
  infer->add_flag("--no-frames", o.no_frames, "draw no frames to measure and show");
  infer->add_flag("--no-comparison", o.no_comparison,
                  "do not compare samplers, regularisation and forward mapping at the report's sample");
  infer->add_option("--report-sample", o.report_sample,
                    "index along each parameter, or a name, of the sample that the report shows (default: the middle)");
  infer->add_flag("--force", o.settings.force, "infer again what is there already");
  add_common_options(*infer, o.common);
  add_decoding_option(*infer);
  infer->callback([options, exit_code] { *exit_code = run_infer(*options); });
}

}  // namespace multum
