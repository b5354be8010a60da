// SPDX-License-Identifier: Apache-2.0
// Writes the report of `multum infer`. The report has every figure as JSON, the most important ones as text, and a page
// with pictures (inference_page.h).
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
  int sample = 0;                                   // sample of the pictures
  const InferenceFrames* frames = nullptr;          // null if frames were not drawn
  const InferenceComparison* comparison = nullptr;  // null if no comparison was made
};

/// One layer of an object, over all its textures. Mean squared errors are over all pixels of all samples, in 8-bit sRGB
/// units. The errors are negative if there are no pixels.
struct LayerSummary {
  std::size_t object = 0, layer = 0;
  int textures = 0;
  int textures_there = 0;  // number of reused textures, whose iterations are unknown
  double squared_error = -1.0, pixel_count = 0.0;
  double forward_squared_error = -1.0;
  double held_out_squared_error = -1.0, held_out_pixel_count = 0.0;  // forward mapping has no held-out samples
  // The highest error of any sample that was used for solving.
  double worst_squared_error = -1.0;
  int worst_sample = -1;
  double iterations_median = 0.0;
  int iterations_max = 0;
  int not_converged = 0;
};

/// Returns summaries in the order of objects, then layers. Layers without textures are left out.
std::vector<LayerSummary> summarise_layers(const InferenceReport& report);

/// Returns the sides of the layer's textures, such as "148 x 96" if `times` is " x ". If the sizes of blocks differ,
/// returns the smallest and the largest size.
std::string texel_count_text(const InferenceReport& report, const LayerSummary& layer, const std::string& times);

/// Returns report.json without its `textures`, because it may list thousands of them.
nlohmann::ordered_json inference_figures(const InferenceReport& report);
/// Returns report.json.
std::string inference_report_json(const InferenceReport& report);

/// Returns lines such as "vase diffuse: MSE 18.3 (forward mapping 62.1), 8 textures of 148 x 96" for each layer, then a
/// line for the frames.
std::string inference_report_text(const InferenceReport& report);

/// Returns the sample in the middle of every parameter.
int middle_sample(const AnimationJob& job);
/// Finds a sample by "3,5", the index along each parameter, or by its name. Throws Error(kUsage) with the valid values.
int sample_named(const AnimationJob& job, const std::string& text);

}  // namespace multum
