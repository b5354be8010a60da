// SPDX-License-Identifier: Apache-2.0
// The report of `multum infer`: every figure as JSON, the few that a person asks for first as text, and a page with
// pictures (inference_page.h).
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "host/fields/inference/pipeline/inference_pipeline.h"
#include "host/fields/inference/report/inference_comparison.h"
#include "host/fields/inference/report/inference_frames.h"

namespace multum {

struct InferenceReport {
  const AnimationJob& job;
  const AnimationInferSettings& settings;
  const AnimationInferResult& result;
  int sample = 0;                                   // that pictures are shown of
  const InferenceFrames* frames = nullptr;          // null: not drawn
  const InferenceComparison* comparison = nullptr;  // null: not made
};

/// One layer of an object: its textures together. Mean squared errors are of all pixels of all samples, 8-bit sRGB
/// units; negative where there is nothing that they are of.
struct LayerSummary {
  std::size_t object = 0, layer = 0;
  int textures = 0;
  int textures_there = 0;  // of them, taken as they were found: their iterations are not known
  double squared_error = -1.0, pixel_count = 0.0;
  double forward_squared_error = -1.0;
  double held_out_squared_error = -1.0, held_out_pixel_count = 0.0;  // forward mapping holds out nothing
  double worst_squared_error = -1.0;                                 // of one sample that was solved for
  int worst_sample = -1;
  double iterations_median = 0.0;
  int iterations_max = 0;
  int not_converged = 0;
};

/// In the order of objects, then layers; a layer without textures is left out.
std::vector<LayerSummary> summarise_layers(const InferenceReport& report);

/// Sides of the layer's textures, "148 x 96" with " x " for `times`; of blocks that differ, the smallest and the
/// largest.
std::string texel_count_text(const InferenceReport& report, const LayerSummary& layer, const std::string& times);

/// report.json without its `textures`, of which there may be thousands.
nlohmann::ordered_json inference_figures(const InferenceReport& report);
/// report.json.
std::string inference_report_json(const InferenceReport& report);

/// "vase diffuse: MSE 18.3 (forward mapping 62.1), 8 textures of 148 x 96", a line for each layer, then the frames.
std::string inference_report_text(const InferenceReport& report);

/// The sample in the middle of every parameter.
int middle_sample(const AnimationJob& job);
/// By "3,5", the index along each parameter, or by its name. Throws Error(kUsage) naming what there is.
int sample_named(const AnimationJob& job, const std::string& text);

}  // namespace multum
