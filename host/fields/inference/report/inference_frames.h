// SPDX-License-Identifier: Apache-2.0
// Runs multum-view to draw frames with the inferred textures, and compares these frames with the ray-traced pictures
// (Hakura et al. 2000, section 3.3). A texture's own error includes only one layer and the pixels used for solving. A
// frame's error includes all layers, silhouettes, and occlusion between objects.
#pragma once

#include <string>
#include <vector>

#include "host/fields/inference/pipeline/parameterized_scene.h"
#include "host/foundation/base/progress.h"

namespace multum {

struct FrameSettings {
  std::string output;            // folder with the manifest; frames go into OUTPUT/frames
  std::string viewer;            // multum-view
  std::string context = "auto";  // OpenGL context of multum-view
};

/// Three values per pixel, with row 0 at the top. The value 1 is the job's radiance_max.
struct RenderedFrame {
  int width = 0, height = 0;
  std::vector<float> rgb;
  std::vector<float> alpha;  // share of the pixel that objects cover
};

/// Means over pixels, in 8-bit sRGB units. Pixels that objects do not cover wholly are left out, because no texture
/// contains the background that they show.
struct FrameErrors {
  int sample = 0;    // index of the job's sample
  std::string file;  // relative to the output folder
  double squared_error = 0.0, pixel_count = 0.0;
  double uncovered_pixels = 0.0;                                   // number of pixels left out because their alpha is
                                                                   // below kWholeCoverage
  double not_finite_pixels = 0.0;                                  // number of pixels left out because they are NaN or
                                                                   // infinite in either picture
  std::vector<double> object_squared_errors, object_pixel_counts;  // one per object of the job, where it covers
                                                                   // pixels wholly in the ray-traced picture
};

struct InferenceFrames {
  std::vector<FrameErrors> frames;
  double seconds = 0.0;  // seconds for drawing, reading and comparing
};

/// The mean error over the pixels of all frames. The count is 0 if there are no pixels.
struct FrameMean {
  double squared_error = 0.0, pixel_count = 0.0;
};
FrameMean mean_frame_error(const InferenceFrames& frames);
FrameMean mean_object_error(const InferenceFrames& frames, std::size_t object);

/// Draws `samples` with the textures in the output folder and compares them. Throws Error or Cancelled.
InferenceFrames render_frames(const ParameterizedScene& field, const FrameSettings& settings,
                              const std::vector<int>& samples, Progress* progress);

/// Returns the ray-traced picture of a frame. This is R G B if the file has these channels, and otherwise the sum of
/// the job's layers. Values are clipped at radiance_max and divided by it.
std::vector<float> ray_traced_picture(const ParameterizedScene& field, int sample);

/// Reads a frame of multum-view. Throws Error(kInput) if it does not have the job's size.
RenderedFrame read_frame(const AnimationJob& job, const std::string& path);

/// Leaves the members `sample` and `file` of the result empty.
FrameErrors compare_frame(const std::vector<float>& ray_traced, const RenderedFrame& frame,
                          const std::vector<std::vector<float>>& coverages);

}  // namespace multum
