// SPDX-License-Identifier: Apache-2.0
#include "host/fields/inference/report/inference_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <tuple>

#include "host/fields/inference/job/animation_samples.h"
#include "host/fields/inference/report/pixel_mean.h"
#include "host/fields/inferred/find_sample.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

using Json = nlohmann::ordered_json;

double median(std::vector<int> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

LayerSummary summarise(const std::vector<TextureResult>& textures, std::size_t object, std::size_t layer) {
  LayerSummary summary;
  summary.object = object;
  summary.layer = layer;
  PixelMean solved, forward, held_out;
  std::vector<int> iterations;
  for (const TextureResult& texture : textures) {
    if (texture.object != object || texture.layer != layer || texture.file.empty()) continue;
    ++summary.textures;
    if (texture.was_there) ++summary.textures_there;
    else iterations.push_back(texture.iterations);
    if (!texture.converged) ++summary.not_converged;
    for (std::size_t i = 0; i < texture.samples.size(); ++i) {
      const double error = texture.squared_errors[i], pixels = texture.pixel_counts[i];
      const bool is_held_out = texture.is_held_out[i];
      (is_held_out ? held_out : solved).add(error, pixels);
      if (!is_held_out && !texture.forward_squared_errors.empty())
        forward.add(texture.forward_squared_errors[i], pixels);
      if (!is_held_out && pixels > 0.0 && error > summary.worst_squared_error) {
        summary.worst_squared_error = error;
        summary.worst_sample = texture.samples[i];
      }
    }
  }
  summary.squared_error = solved.mean(-1.0);
  summary.pixel_count = solved.pixels();
  summary.forward_squared_error = forward.mean(-1.0);
  summary.held_out_squared_error = held_out.mean(-1.0);
  summary.held_out_pixel_count = held_out.pixels();
  summary.iterations_median = median(iterations);
  summary.iterations_max = iterations.empty() ? 0 : *std::max_element(iterations.begin(), iterations.end());
  return summary;
}

// A negative value means that there is no figure.
Json figure(double value) { return value < 0.0 ? Json(nullptr) : Json(value); }

Json ratio(double value, double to) { return value < 0.0 || to <= 0.0 ? Json(nullptr) : Json(value / to); }

Json settings_json(const InferenceReport& report) {
  const AnimationInferSettings& s = report.settings;
  return {{"gradient_tolerance", s.gradient_tolerance},
          {"iteration_max", s.iteration_max},
          {"hold_out", s.hold_out},
          {"with_baseline", s.with_baseline},
          {"context", s.context},
          {"threads", s.threads},
          {"supersampling", report.job.supersampling},
          {"radiance_max", report.job.radiance_max},
          {"coverage_min", report.job.coverage_min}};
}

Json mapping_json(const TextureMapping& mapping) {
  if (mapping.width == 0) return nullptr;
  Json cut = Json::array();
  for (std::size_t d = 0; d < 2; ++d) cut.push_back(mapping.has_cut[d] ? Json(mapping.cut[d]) : Json(nullptr));
  return {{"width", mapping.width},
          {"height", mapping.height},
          {"stretch_max", mapping.stretch_max},
          {"stretch_rounds", mapping.stretch_rounds},
          {"cut", cut},
          {"visible_pixels", mapping.visible_pixels},
          {"degenerate_pixels", mapping.degenerate_pixels}};
}

Json layer_json(const InferenceReport& report, const LayerSummary& one) {
  Json json = {{"name", report.job.layers[one.layer].name},
               {"textures", one.textures},
               {"textures_there", one.textures_there},
               {"mse", figure(one.squared_error)},
               {"pixels", one.pixel_count},
               {"forward_mapping_mse", figure(one.forward_squared_error)},
               {"ratio", ratio(one.squared_error, one.forward_squared_error)}};
  json["worst_sample"] = one.worst_sample < 0
                             ? Json(nullptr)
                             : Json{{"name", report.job.samples[static_cast<std::size_t>(one.worst_sample)].name},
                                    {"mse", one.worst_squared_error}};
  json["held_out"] = one.held_out_squared_error < 0.0
                         ? Json(nullptr)
                         : Json{{"mse", one.held_out_squared_error}, {"pixels", one.held_out_pixel_count}};
  json["iterations"] = one.textures_there == one.textures
                           ? Json(nullptr)
                           : Json{{"median", one.iterations_median}, {"max", one.iterations_max}};
  json["not_converged"] = one.not_converged;
  return json;
}

Json objects_json(const InferenceReport& report) {
  const std::vector<LayerSummary> layers = summarise_layers(report);
  Json list = Json::array();
  for (std::size_t k = 0; k < report.job.objects.size(); ++k) {
    const AnimationObject& object = report.job.objects[k];
    const AnimationTexture& t = object.texture;
    Json json = {{"name", object.name},
                 {"mesh", object.mesh},
                 {"texture",
                  {{"wrap", t.wrap},
                   {"stretch_max", t.stretch_max},
                   {"resolution_scale", t.resolution_scale},
                   {"power_of_two", t.power_of_two},
                   {"side_max", t.side_max},
                   {"anisotropy", t.anisotropy},
                   {"pyramid_weight", t.pyramid_weight},
                   {"range_weight", t.range_weight}}},
                 {"mappings", Json::array()},
                 {"layers", Json::array()}};
    for (const TextureMapping& mapping : report.result.mappings[k]) json["mappings"].push_back(mapping_json(mapping));
    for (const LayerSummary& layer : layers)
      if (layer.object == k) json["layers"].push_back(layer_json(report, layer));
    if (report.frames != nullptr) {
      const FrameMean mean = mean_object_error(*report.frames, k);
      json["frames"] = {{"mse", mean.pixel_count > 0.0 ? Json(mean.squared_error) : Json(nullptr)},
                        {"pixels", mean.pixel_count}};
    }
    list.push_back(json);
  }
  return list;
}

Json texture_json(const InferenceReport& report, const TextureResult& texture) {
  const AnimationJob& job = report.job;
  Json json = {{"object", job.objects[texture.object].name},
               {"layer", job.layers[texture.layer].name},
               {"block", report.result.blocks[static_cast<std::size_t>(texture.block)]},
               {"file", texture.file},
               {"was_there", texture.was_there},
               {"converged", texture.converged},
               {"iterations", texture.iterations},
               {"samples", Json::array()},
               {"newton", Json::array()}};
  for (std::size_t i = 0; i < texture.samples.size(); ++i) {
    Json sample = {{"name", job.samples[static_cast<std::size_t>(texture.samples[i])].name},
                   {"held_out", static_cast<bool>(texture.is_held_out[i])},
                   {"pixels", texture.pixel_counts[i]},
                   {"mse", texture.squared_errors[i]}};
    if (!texture.forward_squared_errors.empty()) sample["forward_mapping_mse"] = texture.forward_squared_errors[i];
    json["samples"].push_back(sample);
  }
  for (const InferenceStep& step : texture.history)
    json["newton"].push_back({{"iteration", step.iteration},
                              {"objective", step.objective},
                              {"gradient_ratio", step.gradient_ratio},
                              {"held", step.held}});
  return json;
}

Json segmentation_json(const SegmentationReport& s) {
  return {{"not_finite_pixels", s.not_finite_pixels}, {"negative_pixels", s.negative_pixels},
          {"repaired_pixels", s.repaired_pixels},     {"dropped_pixels", s.dropped_pixels},
          {"mixed_pixels", s.mixed_pixels},           {"unguided_pixels", s.unguided_pixels},
          {"clamped_values", s.clamped_values},       {"clipped_values", s.clipped_values}};
}

Json seconds_json(const StageSeconds& s) {
  return {{"mapping", s.mapping}, {"probing", s.probing},   {"segmentation", s.segmentation}, {"systems", s.systems},
          {"solving", s.solving}, {"baseline", s.baseline}, {"rendering", s.rendering}};
}

Json frames_json(const AnimationJob& job, const InferenceFrames& frames) {
  const FrameMean mean = mean_frame_error(frames);
  Json json = {{"mse", mean.pixel_count > 0.0 ? Json(mean.squared_error) : Json(nullptr)},
               {"pixels", mean.pixel_count},
               {"seconds", frames.seconds},
               {"samples", Json::array()}};
  for (const FrameErrors& frame : frames.frames) {
    Json one = {{"name", job.samples[static_cast<std::size_t>(frame.sample)].name},
                {"file", frame.file},
                {"mse", frame.pixel_count > 0.0 ? Json(frame.squared_error) : Json(nullptr)},
                {"pixels", frame.pixel_count},
                {"uncovered_pixels", frame.uncovered_pixels},
                {"not_finite_pixels", frame.not_finite_pixels},
                {"objects", Json::array()}};
    for (std::size_t k = 0; k < frame.object_pixel_counts.size(); ++k) {
      const bool is_seen = frame.object_pixel_counts[k] > 0.0;
      one["objects"].push_back({{"name", job.objects[k].name},
                                {"mse", is_seen ? Json(frame.object_squared_errors[k]) : Json(nullptr)},
                                {"pixels", frame.object_pixel_counts[k]}});
    }
    json["samples"].push_back(one);
  }
  return json;
}

Json comparison_json(const AnimationJob& job, const InferenceComparison& comparison) {
  Json json = {{"sample", comparison.sample},
               {"supersampling", comparison.supersampling},
               {"pixels", Json::object()},
               {"rows", Json::array()}};
  for (std::size_t k = 0; k < comparison.pixel_counts.size(); ++k)
    json["pixels"][job.objects[k].name] = comparison.pixel_counts[k];
  for (const ComparisonRow& row : comparison.rows) {
    Json errors = Json::object();
    for (std::size_t k = 0; k < row.squared_errors.size(); ++k)
      errors[job.objects[k].name] = figure(row.squared_errors[k]);
    json["rows"].push_back({{"name", row.name}, {"mse", errors}});
  }
  return json;
}

}  // namespace

std::vector<LayerSummary> summarise_layers(const InferenceReport& report) {
  std::vector<LayerSummary> summaries;
  for (std::size_t k = 0; k < report.job.objects.size(); ++k)
    for (std::size_t l = 0; l < report.job.layers.size(); ++l) {
      const LayerSummary summary = summarise(report.result.textures, k, l);
      if (summary.textures > 0) summaries.push_back(summary);
    }
  return summaries;
}

Json inference_figures(const InferenceReport& report) {
  const AnimationJob& job = report.job;
  const AnimationInferResult& result = report.result;
  Json json;
  json["software"] = std::string("multum ") + MULTUM_VERSION;
  json["job"] =
      // Contains no folder names, because users send reports to others.
      text_of_path(std::filesystem::path(job.path).filename().string());
  json["device"] = result.device;
  json["renderer"] = result.renderer;
  json["settings"] = settings_json(report);
  json["width"] = job.width;
  json["height"] = job.height;
  json["parameters"] = Json::array();
  for (const AnimationParameter& parameter : job.parameters)
    json["parameters"].push_back({{"name", parameter.name}, {"count", parameter.count}, {"view", parameter.is_view}});
  json["report_sample"] = job.samples[static_cast<std::size_t>(report.sample)].name;
  json["blocks"] = result.blocks;
  json["objects"] = objects_json(report);
  json["segmentation"] = segmentation_json(result.segmentation);
  json["nan_depths"] = result.nan_depths;
  json["rows"] = result.rows;
  json["rows_rejected"] = result.rows_rejected;
  json["matrices_measured"] = result.matrices_measured;
  json["systems"] = {{"normal", result.systems_normal}, {"matrix", result.systems_matrix}};
  json["seconds"] = seconds_json(result.seconds);
  json["frames"] = report.frames != nullptr ? frames_json(job, *report.frames) : Json(nullptr);
  json["comparison"] = report.comparison != nullptr ? comparison_json(job, *report.comparison) : Json(nullptr);
  return json;
}

std::string inference_report_json(const InferenceReport& report) {
  Json json = inference_figures(report);
  json["textures"] = Json::array();
  for (const TextureResult& texture : report.result.textures)
    if (!texture.file.empty()) json["textures"].push_back(texture_json(report, texture));
  return json_text(json, 1) + "\n";
}

std::string texel_count_text(const InferenceReport& report, const LayerSummary& layer, const std::string& times) {
  std::set<std::tuple<int, int, int>> sizes;  // sorted by area
  for (const TextureResult& texture : report.result.textures) {
    if (texture.object != layer.object || texture.layer != layer.layer || texture.file.empty()) continue;
    const TextureMapping& m = report.result.mappings[layer.object][static_cast<std::size_t>(texture.block)];
    sizes.insert({m.width * m.height, m.width, m.height});
  }
  const auto text = [&](const std::tuple<int, int, int>& size) {
    return fmt::format("{}{}{}", std::get<1>(size), times, std::get<2>(size));
  };
  if (sizes.empty()) return "";
  return sizes.size() == 1 ? text(*sizes.begin()) : text(*sizes.begin()) + " to " + text(*sizes.rbegin());
}

std::string inference_report_text(const InferenceReport& report) {
  const AnimationJob& job = report.job;
  std::string text;
  for (const LayerSummary& one : summarise_layers(report)) {
    text += fmt::format("{} {}: MSE {:.1f}", job.objects[one.object].name, job.layers[one.layer].name,
                        std::max(0.0, one.squared_error));
    if (one.forward_squared_error >= 0.0) text += fmt::format(" (forward mapping {:.1f})", one.forward_squared_error);
    if (one.held_out_squared_error >= 0.0) text += fmt::format(", held out {:.1f}", one.held_out_squared_error);
    text += fmt::format(", {} texture{} of {}", one.textures, one.textures == 1 ? "" : "s",
                        texel_count_text(report, one, " x "));
    if (one.not_converged > 0) text += fmt::format(", {} not converged", one.not_converged);
    text += "\n";
  }
  if (report.frames == nullptr || report.frames->frames.empty()) return text;
  const std::vector<FrameErrors>& frames = report.frames->frames;
  const auto worst = std::max_element(frames.begin(), frames.end(), [](const FrameErrors& a, const FrameErrors& b) {
    return a.squared_error < b.squared_error;
  });
  return text + fmt::format("frames: MSE {:.1f} over {} samples, at most {:.1f} ({})\n",
                            mean_frame_error(*report.frames).squared_error, frames.size(), worst->squared_error,
                            job.samples[static_cast<std::size_t>(worst->sample)].name);
}

int middle_sample(const AnimationJob& job) {
  for (std::size_t s = 0; s < job.samples.size(); ++s) {
    bool is_middle = true;
    for (std::size_t d = 0; d < job.parameters.size(); ++d)
      is_middle = is_middle && job.samples[s].at[d] == job.parameters[d].count / 2;
    if (is_middle) return static_cast<int>(s);
  }
  return 0;
}

int sample_named(const AnimationJob& job, const std::string& text) {
  return static_cast<int>(find_sample(job.samples, names_of(job.parameters), text));
}

}  // namespace multum
