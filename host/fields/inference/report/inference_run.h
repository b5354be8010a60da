// SPDX-License-Identifier: Apache-2.0
// Does the whole work of `multum infer` for the program and the library: infers the textures of a job, draws frames
// with them, compares samplers, and writes the manifest and the report.
#pragma once

#include <optional>
#include <string>

#include "host/fields/inference/report/inference_report.h"
#include "host/foundation/parameters/parameter_values.h"

namespace multum {

struct InferenceRunSettings {
  AnimationInferSettings inference;
  bool has_frames = true;      // draw frames with the textures, and compare them with the ray-traced pictures
  bool has_comparison = true;  // compare samplers at the sample of the report
  std::string report_sample;   // name or indices of the report's sample; empty means the middle sample
};

/// Sets all members except the output, the viewer and the number of threads.
void apply(const ParameterValues& values, InferenceRunSettings& settings);

/// The results of an inference. Copies are not allowed, because report() points into the object.
struct InferenceRun {
  InferenceRun() = default;
  InferenceRun(const InferenceRun&) = delete;
  InferenceRun& operator=(const InferenceRun&) = delete;

  AnimationInferResult result;
  int sample = 0;  // sample of the report
  std::optional<InferenceFrames> frames;
  std::optional<InferenceComparison> comparison;

  /// The arguments and this object must outlive the report.
  InferenceReport report(const ParameterizedScene& field, const InferenceRunSettings& settings) const;
};

/// Infers all textures into an existing folder, and writes the report. If `merged_shards` is above 0, uses the textures
/// of that many shares instead (inference_share.h). Throws Error(kUsage) for an unknown sample of the report, and the
/// errors of infer_animation() and merge_inference().
void run_inference(const ParameterizedScene& field, const InferenceRunSettings& settings, int merged_shards,
                   Progress* progress, InferenceRun& run);

}  // namespace multum
