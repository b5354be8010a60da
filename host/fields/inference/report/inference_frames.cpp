// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/report/inference_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/fields/inference/pipeline/inference_pipeline.h"
#include "host/fields/inference/pipeline/inference_rows.h"
#include "host/fields/inference/report/pixel_mean.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

// The number of samples per run of the viewer. Each run sets up OpenGL and reads the geometry once. With this number,
// the command line stays far below the 128 KiB that every system accepts.
constexpr std::size_t kSamplesAChild = 256;

const std::vector<std::string> kRgb = {"R", "G", "B"};

std::vector<float> interleaved(const ExrLayers& layers, double radiance_max) {
  const std::vector<float>* planes[3] = {&layers.channels.at("R"), &layers.channels.at("G"), &layers.channels.at("B")};
  std::vector<float> rgb(3 * planes[0]->size());
  for (std::size_t i = 0; i < rgb.size(); ++i)
    rgb[i] = static_cast<float>(static_cast<double>((*planes[i % 3])[i / 3]) / radiance_max);
  return rgb;
}

std::string frame_file(const AnimationJob& job, int sample) {
  return "frames/" + job.samples[static_cast<std::size_t>(sample)].name + ".exr";
}

void draw_frames(const AnimationJob& job, const FrameSettings& settings, const std::vector<int>& samples,
                 Progress* progress) {
  std::vector<std::string> command = {settings.viewer, "sample", settings.output, "--context", settings.context};
  for (const int sample : samples) {
    command.insert(command.end(), {"--at", job.samples[static_cast<std::size_t>(sample)].name});
    command.insert(command.end(), {"-o", settings.output + "/" + frame_file(job, sample)});
  }
  run_viewer(command, fmt::format("drawing {} frames from '{}'", samples.size(), settings.output), progress);
}

bool has_rgb(const std::string& path) {
  const std::vector<std::string> channels = exr_channel_names(path);
  return std::all_of(kRgb.begin(), kRgb.end(), [&](const std::string& channel) {
    return std::find(channels.begin(), channels.end(), channel) != channels.end();
  });
}

}  // namespace

std::vector<float> ray_traced_picture(const ParameterizedScene& field, int sample) {
  const AnimationJob& job = field.job();
  const std::string& path = job.samples[static_cast<std::size_t>(sample)].radiance;
  std::vector<float> picture;
  if (has_rgb(path)) {
    const ExrLayers layers = read_exr_channels(path, kRgb);
    check_size(job, path, layers);
    picture = interleaved(layers, job.radiance_max);
  } else {
    for (const AnimationLayer& layer : job.layers) {
      const std::vector<float> one = field.layer_picture(sample, layer);
      picture.resize(one.size(), 0.0f);
      std::transform(one.begin(), one.end(), picture.begin(), picture.begin(), std::plus<>());
    }
    divide(picture, job.radiance_max);
  }
  for (float& value : picture) value = std::clamp(value, 0.0f, 1.0f);  // keeps NaN, which the comparison counts
  return picture;
}

RenderedFrame read_frame(const AnimationJob& job, const std::string& path) {
  ExrLayers layers = read_exr_channels(path, {"R", "G", "B", "A"});
  check_size(job, path, layers);
  return {layers.width, layers.height, interleaved(layers, job.radiance_max), std::move(layers.channels.at("A"))};
}

FrameErrors compare_frame(const std::vector<float>& ray_traced, const RenderedFrame& frame,
                          const std::vector<std::vector<float>>& coverages) {
  MULTUM_CHECK(ray_traced.size() == frame.rgb.size() && frame.rgb.size() == 3 * frame.alpha.size());
  FrameErrors errors;
  PixelMean whole;
  std::vector<PixelMean> objects(coverages.size());
  for (std::size_t i = 0; i < frame.alpha.size(); ++i) {
    const float* traced = &ray_traced[3 * i];
    const float* drawn = &frame.rgb[3 * i];
    // NaN is not less than the limit, so the next test counts such a pixel as not finite.
    if (frame.alpha[i] < kWholeCoverage) {
      errors.uncovered_pixels += 1.0;
      continue;
    }
    const auto is_finite = [](const float* rgb) {
      return std::all_of(rgb, rgb + 3, [](float v) { return std::isfinite(v); });
    };
    if (!std::isfinite(frame.alpha[i]) || !is_finite(traced) || !is_finite(drawn)) {
      errors.not_finite_pixels += 1.0;
      continue;
    }
    const double error = squared_error_8bit(traced, drawn);
    whole.add(error, 1.0);
    for (std::size_t k = 0; k < coverages.size(); ++k)
      if (coverages[k][i] >= kWholeCoverage) objects[k].add(error, 1.0);
  }
  errors.squared_error = whole.mean(0.0);
  errors.pixel_count = whole.pixels();
  for (const PixelMean& object : objects) {
    errors.object_squared_errors.push_back(object.mean(0.0));
    errors.object_pixel_counts.push_back(object.pixels());
  }
  return errors;
}

InferenceFrames render_frames(const ParameterizedScene& field, const FrameSettings& settings,
                              const std::vector<int>& samples, Progress* progress) {
  const Stopwatch stopwatch;
  const AnimationJob& job = field.job();
  InferenceFrames result;
  make_folder(settings.output + "/frames");
  progress_start(progress, 2 * samples.size());  // two units per frame, for drawing and comparing
  for (std::size_t begin = 0; begin < samples.size(); begin += kSamplesAChild) {
    const std::size_t end = std::min(samples.size(), begin + kSamplesAChild);
    const std::vector<int> some(samples.begin() + static_cast<std::ptrdiff_t>(begin),
                                samples.begin() + static_cast<std::ptrdiff_t>(end));
    progress_stage(progress, "draw frames");
    draw_frames(job, settings, some, progress);
    progress_advance(progress, some.size());
    progress_stage(progress, "compare frames");
    for (const int sample : some) {
      const RenderedFrame frame = read_frame(job, settings.output + "/" + frame_file(job, sample));
      FrameErrors errors = compare_frame(ray_traced_picture(field, sample), frame, field.coverages(sample));
      errors.sample = sample;
      errors.file = frame_file(job, sample);
      result.frames.push_back(std::move(errors));
      progress_advance(progress, 1);
    }
  }
  result.seconds = stopwatch.seconds();
  return result;
}

FrameMean mean_frame_error(const InferenceFrames& frames) {
  PixelMean sum;
  for (const FrameErrors& frame : frames.frames) sum.add(frame.squared_error, frame.pixel_count);
  return {sum.mean(0.0), sum.pixels()};
}

FrameMean mean_object_error(const InferenceFrames& frames, std::size_t object) {
  PixelMean sum;
  for (const FrameErrors& frame : frames.frames)
    sum.add(frame.object_squared_errors[object], frame.object_pixel_counts[object]);
  return {sum.mean(0.0), sum.pixels()};
}

}  // namespace multum
