// SPDX-License-Identifier: Apache-2.0
// Implements the fields of multum.h.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "host/api/api_call.h"
#include "host/api/api_device.h"
#include "host/api/api_error.h"
#include "host/api/api_values.h"
#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packing/pack_job.h"
#include "host/fields/codec/transforms/device_image_transforms.h"
#include "host/fields/inference/job/animation_job_reading.h"
#include "host/fields/inference/report/inference_run.h"
#include "host/fields/playback/field_point.h"
#include "host/fields/player/player_output.h"
#include "host/formats/image/files/exr_layers.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/parameters/infer_parameters.h"
#include "host/foundation/parameters/pack_parameters.h"

struct multum_field {
  explicit multum_field(const std::string& name)
      : file(std::filesystem::absolute(name).string()), text(multum::packed_field_facts(file)) {}

  const std::string& path() const { return file.path(); }
  const multum::FieldDescription& description() const { return file.description(); }
  /// Returns the number of floats in a frame.
  std::size_t frame_values() const {
    return 4 * static_cast<std::size_t>(description().field.width) *
           static_cast<std::size_t>(description().field.height);
  }

  multum::PackedFieldFile file;
  std::string text;
  std::mutex mutex;  // guards the file while chunks are read
};

namespace multum {
namespace {

// The number of frames that one run of multum-view draws.
constexpr int kFramesOfARun = 500;

// Copies the point, and checks that its numbers are finite.
std::vector<double> checked_point(const multum_field& field, const double* point, const char* function) {
  std::vector<double> result(point, point + field.description().grid.sizes.size());
  for (std::size_t p = 0; p < result.size(); ++p)
    if (!std::isfinite(result[p]))
      throw Error(ErrorCode::kUsage, fmt::format("{}: the value of parameter '{}' is {}, expected a finite number",
                                                 function, field.description().field.parameters[p], result[p]));
  return result;
}

// Returns a recorded path that is at point number i after i seconds. The last point is there twice, because a path
// starts again at its end.
std::string path_text(const multum_field& field, const std::vector<std::vector<double>>& points) {
  nlohmann::json positions = nlohmann::json::array();
  for (std::size_t i = 0; i <= points.size(); ++i) {
    std::vector<double> position = points[std::min(i, points.size() - 1)];
    position.insert(position.begin(), static_cast<double>(i));
    positions.push_back(position);
  }
  return json_text(nlohmann::json{
      {"multumPath", 1}, {"parameters", field.description().field.parameters}, {"positions", positions}});
}

void copy_frame(const multum_field& field, const std::string& path, float* rgba) {
  const std::vector<std::string> names = {"R", "G", "B", "A"};
  const ExrLayers frame = read_exr_channels(path, names);
  const InferredManifest& description = field.description().field;
  MULTUM_CHECK(frame.width == description.width && frame.height == description.height);
  for (std::size_t c = 0; c < names.size(); ++c) {
    const std::vector<float>& plane = frame.channels.at(names[c]);
    for (std::size_t i = 0; i < plane.size(); ++i) rgba[4 * i + c] = plane[i];
  }
}

void play_frames(const multum_field& field, const std::vector<std::vector<double>>& points, bool is_linear,
                 Progress* progress, float* rgba) {
  const auto folder = WorkFolder::make(std::filesystem::temp_directory_path().string());
  const std::string path = folder->path() + "/path.json";
  write_text_file(path, path_text(field, points));
  std::vector<std::string> command = {find_viewer(),
                                      "play",
                                      field.path(),
                                      "--path",
                                      path,
                                      "-o",
                                      folder->path() + "/frames",
                                      "--frames",
                                      fmt::format("{}", points.size()),
                                      "--rate",
                                      "1",
                                      "--exr"};
  if (is_linear) command.emplace_back("--linear");
  try {
    run_viewer(command, fmt::format("drawing {} frames of {}", points.size(), field.path()), progress);
  } catch (const Error& error) {
    // The viewer has drawn the frames without the damaged parts, but this function returns no incomplete frames. The
    // first line says what was drawn. The next lines name the file and each damaged part.
    if (error.code() != ErrorCode::kVerification) throw;
    const std::string text = error.what();
    const std::size_t parts = text.find_first_not_of("\n ", text.find('\n'));
    throw Error(ErrorCode::kInput, parts == std::string::npos ? field.path() + ": " + text : text.substr(parts));
  }
  for (std::size_t i = 0; i < points.size(); ++i)
    copy_frame(field, fmt::format("{}/frames/frame_{:04}.exr", folder->path(), i), rgba + i * field.frame_values());
}

// Returns the chunk of a layer at a sample, or null if the layer is invisible there.
std::unique_ptr<TextureChunk> chunk_at(multum_field& field, const PackedLayer& layer, std::size_t number,
                                       std::size_t sample, std::size_t& block) {
  if (!layer.is_seen(sample)) return nullptr;
  block = layer.block_at(field.description().field.samples[sample].at);
  const std::lock_guard lock(field.mutex);
  return field.file.chunk(number, block);
}

}  // namespace
}  // namespace multum

using multum::Error;
using multum::ErrorCode;
using multum::guarded;

multum_status multum_infer(multum_device* device, const char* job, const multum_values* values, const char* output,
                           const multum_callbacks* callbacks, multum_text** report, multum_error** error) {
  return guarded(error, [&] {
    multum::require(device, "multum_infer", "device", "a device");
    multum::require(job, "multum_infer", "job", "the name of a job file");
    multum::require(output, "multum_infer", "output", "a folder");
    multum::ApiCall call(callbacks);
    multum::InferenceRunSettings settings;
    multum::apply(multum::values_of(values, multum::infer_parameters()), settings);
    settings.inference.output = output;
    settings.inference.threads = multum::threads_of(values);
    settings.inference.viewer = multum::find_viewer();
    const multum::ParameterizedScene field(multum::read_animation_job(job));
    const multum::NewFolders new_folders;
    multum::make_folder(output);
    const multum::DeviceUse use(*device, call.progress());
    settings.inference.opened = device->device;
    multum::InferenceRun run;
    multum::run_inference(field, settings, 0, call.progress(), run);
    if (report != nullptr) *report = new multum_text{multum::inference_report_json(run.report(field, settings))};
  });
}

multum_status multum_pack(multum_device* device, const char* folder, const multum_values* values, const char* output,
                          const multum_callbacks* callbacks, multum_text** report, multum_error** error) {
  return guarded(error, [&] {
    multum::require(device, "multum_pack", "device", "a device");
    multum::require(folder, "multum_pack", "folder", "a folder of multum_infer()");
    multum::require(output, "multum_pack", "output", "the name of a file to write");
    multum::ApiCall call(callbacks);
    const multum::ParameterValues parameters = multum::values_of(values, multum::pack_parameters());
    multum::check_exclusions(parameters);
    multum::FieldPackSettings settings;
    multum::apply(parameters, settings);
    settings.folder = multum::field_folder(folder);
    settings.output = output;
    settings.threads = multum::threads_of(values);
    const multum::NewFolders new_folders;
    multum::make_folder_of(output);
    const multum::DeviceUse use(*device, call.progress());
    multum::DeviceImageTransforms transforms(device->device);
    settings.transforms = &transforms;
    const multum::FieldPackReport made = multum::pack_field(settings, call.progress());
    multum::warn_of_pack_errors(settings, made);
    if (report != nullptr) *report = new multum_text{multum::pack_report_json(settings, made)};
  });
}

multum_status multum_publish_field(const char* packed, const char* output, multum_error** error) {
  return guarded(error, [&] {
    multum::require(packed, "multum_publish_field", "packed", "the name of a packed field");
    multum::require(output, "multum_publish_field", "output", "a folder, or a page named *.html");
    const multum::ApiCall call(nullptr);
    const bool is_page = std::filesystem::path(output).extension() == ".html";
    const multum::PlayerOutput player{is_page ? "" : output, is_page ? output : ""};
    multum::check_paths_differ({packed}, {output});
    const multum::NewFolders new_folders;
    multum::make_folder_of(output);
    multum::check_player_output(player);
    multum::write_player(packed, player);
  });
}

multum_status multum_field_open(const char* path, multum_field** field, multum_error** error) {
  return guarded(error, [&] {
    multum::require(path, "multum_field_open", "path", "the name of a packed field");
    multum::require(field, "multum_field_open", "field", "a place for the result");
    const multum::ApiCall call(nullptr);
    *field = new multum_field(path);
  });
}

void multum_field_free(multum_field* field) { delete field; }

const char* multum_field_text(const multum_field* field) { return field == nullptr ? "" : field->text.c_str(); }

multum_status multum_field_texture(multum_field* field, int layer, const double* point, multum_view* shape, float* rgb,
                                   multum_error** error) {
  return guarded(error, [&] {
    multum::require(field, "multum_field_texture", "field", "a field");
    multum::require(point, "multum_field_texture", "point", "a number for each parameter");
    multum::require(shape, "multum_field_texture", "shape", "a place for the shape");
    const multum::ApiCall call(nullptr);
    const multum::FieldDescription& description = field->description();
    const int count = static_cast<int>(description.layers.size());
    if (layer < 0 || layer >= count)
      throw Error(ErrorCode::kUsage,
                  fmt::format("layer is {}, expected 0 to {}, the layers of {}", layer, count - 1, field->path()));
    const auto number = static_cast<std::size_t>(layer);
    const std::size_t sample = multum::nearest_sample(
        description.grid,
        multum::clamped_point(description.grid, multum::checked_point(*field, point, "multum_field_texture")));
    *shape = {};
    std::size_t block = 0;
    const multum::PackedLayer& packed = description.layers[number];
    const auto chunk = multum::chunk_at(*field, packed, number, sample, block);
    if (chunk == nullptr) return;
    *shape = {nullptr, 1, static_cast<int>(chunk->format().height), static_cast<int>(chunk->format().width), 3};
    if (rgb == nullptr) return;
    const std::vector<float> levels =
        multum::radiance_levels(*chunk, packed.blocks[block].chunk_sample(description.field.samples[sample].at));
    const std::size_t finest = 3 * chunk->format().width * chunk->format().height;
    std::copy_n(levels.begin(), finest, rgb);
  });
}

multum_status multum_field_play(multum_field* field, const double* points, int count, int is_linear,
                                const multum_callbacks* callbacks, float* rgba, multum_error** error) {
  return guarded(error, [&] {
    multum::require(field, "multum_field_play", "field", "a field");
    multum::require(points, "multum_field_play", "points", "a number for each parameter and frame");
    multum::require(rgba, "multum_field_play", "rgba", "room for the frames");
    if (count < 1)
      throw Error(ErrorCode::kUsage, fmt::format("multum_field_play: count is {}, expected at least 1", count));
    multum::ApiCall call(callbacks);
    const std::size_t parameters = field->description().grid.sizes.size();
    multum::progress_start(call.progress(), static_cast<std::uint64_t>(count));
    multum::progress_stage(call.progress(), "draw frames");
    for (int begin = 0; begin < count; begin += multum::kFramesOfARun) {
      std::vector<std::vector<double>> some;
      for (int i = begin; i < std::min(count, begin + multum::kFramesOfARun); ++i)
        some.push_back(
            multum::checked_point(*field, points + static_cast<std::size_t>(i) * parameters, "multum_field_play"));
      multum::play_frames(*field, some, is_linear != 0, call.progress(),
                          rgba + static_cast<std::size_t>(begin) * field->frame_values());
      multum::progress_advance(call.progress(), some.size());
    }
    multum::progress_finish(call.progress());
  });
}
