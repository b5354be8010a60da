// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/report/inference_run.h"

#include <numeric>
#include <vector>

#include "host/fields/inference/pipeline/inference_share.h"
#include "host/fields/inference/report/inference_page.h"

namespace multum {
namespace {

std::vector<int> all_samples(const AnimationJob& job) {
  std::vector<int> samples(job.samples.size());
  std::iota(samples.begin(), samples.end(), 0);
  return samples;
}

}  // namespace

void apply(const ParameterValues& values, InferenceRunSettings& settings) {
  AnimationInferSettings& inference = settings.inference;
  inference.device = values.text("device").value_or(inference.device);
  inference.context = values.text("context").value_or(inference.context);
  inference.gradient_tolerance = values.number("tolerance").value_or(inference.gradient_tolerance);
  inference.iteration_max = values.integer("iterations").value_or(inference.iteration_max);
  inference.hold_out = values.integer("hold_out").value_or(inference.hold_out);
  if (values.flag("force")) inference.force = true;
  inference.has_absolute_geometry = values.flag("absolute_geometry");
  settings.has_frames = !values.flag("no_frames");
  settings.has_comparison = !values.flag("no_comparison");
  settings.report_sample = values.text("report_sample").value_or(settings.report_sample);
}

InferenceReport InferenceRun::report(const ParameterizedScene& field, const InferenceRunSettings& settings) const {
  return {field.job(), settings.inference,          result,
          sample,      frames ? &*frames : nullptr, comparison ? &*comparison : nullptr};
}

void run_inference(const ParameterizedScene& field, const InferenceRunSettings& settings, int merged_shards,
                   Progress* progress, InferenceRun& run) {
  const AnimationInferSettings& inference = settings.inference;
  run.sample =
      settings.report_sample.empty() ? middle_sample(field.job()) : sample_named(field.job(), settings.report_sample);
  run.result = merged_shards > 0 ? merge_inference(field, inference, merged_shards, progress)
                                 : infer_animation(field, inference, progress);
  if (settings.has_frames) {
    run.frames = render_frames(field, {inference.output, inference.viewer, inference.context}, all_samples(field.job()),
                               progress);
    run.result.seconds.rendering = run.frames->seconds;
  }
  if (settings.has_comparison)
    run.comparison = compare_inference(field, run.sample, run.result.mappings, inference, progress);
  write_inference_report(field, run.report(field, settings));
}

}  // namespace multum
