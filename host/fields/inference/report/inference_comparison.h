// SPDX-License-Identifier: Apache-2.0
// Compares settings at one sample, as in figure 6 of Hakura et al. 2000. Each object's layers are inferred from this
// picture with bilinear, trilinear and anisotropic filtering, with and without pyramidal regularization. The results
// are compared with forward mapping.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/pipeline/inference_pipeline.h"

namespace multum {

struct ComparisonRow {
  std::string name;                    // "trilinear, regularisation 0.1"
  std::vector<double> squared_errors;  // one per object of the job, all layers added, over wholly covered pixels, in
                                       // 8-bit sRGB units; negative if not visible
};

struct InferenceComparison {
  std::string sample;
  int supersampling = 1;             // supersampling of the matrix rows
  std::vector<double> pixel_counts;  // pixels of each of the job's objects
  std::vector<ComparisonRow> rows;
};

/// Compares the settings with one sample per pixel, as hardware draws without antialiasing, and with the job's
/// supersampling. Anisotropic filtering is left out with supersampling, because measuring its footprints takes many
/// draws. Stores the measured matrices in OUTPUT/comparison.
InferenceComparison compare_inference(const ParameterizedScene& field, int sample, const ObjectMappings& mappings,
                                      const AnimationInferSettings& settings, Progress* progress);

}  // namespace multum
