// SPDX-License-Identifier: Apache-2.0
// Implements the bakes, exports and measurements of multum.h.
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "host/api/api_call.h"
#include "host/api/api_device.h"
#include "host/api/api_error.h"
#include "host/api/api_map.h"
#include "host/api/api_values.h"
#include "host/bakes/accuracy/accuracy_table.h"
#include "host/bakes/bake/bake_file.h"
#include "host/bakes/bake/baked_check.h"
#include "host/bakes/bake/job_parameters.h"
#include "host/bakes/settings_search/target_parameters.h"
#include "host/delivery/export/batch/export_batch.h"
#include "host/delivery/export/export_job.h"
#include "host/delivery/gltf/gltf_job.h"
#include "host/formats/image/files/number_type.h"
#include "host/foundation/base/files/memory_images.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/processes/viewer_process.h"
#include "host/foundation/parameters/export_parameters.h"
#include "host/foundation/parameters/gltf_parameters.h"

namespace multum {
namespace {

struct StoredType {
  multum_type type;
  int base_type;
};
constexpr StoredType kTypes[] = {{MULTUM_UINT8, number_type::kUint8},
                                 {MULTUM_UINT16, number_type::kUint16},
                                 {MULTUM_HALF, number_type::kHalf},
                                 {MULTUM_FLOAT, number_type::kFloat}};

std::vector<std::string> channel_names(int count) {
  switch (count) {
    case 1: return {"Y"};
    case 2: return {"Y", "A"};
    case 3: return {"R", "G", "B"};
    default: return {"R", "G", "B", "A"};
  }
}

int base_type_of(const multum_image& image, const std::string& name) {
  for (const StoredType& one : kTypes)
    if (one.type == image.type) return one.base_type;
  throw Error(ErrorCode::kUsage,
              fmt::format("{}: type is {}, expected MULTUM_UINT8, MULTUM_UINT16, MULTUM_HALF or MULTUM_FLOAT", name,
                          static_cast<int>(image.type)));
}

MemoryImage memory_image(const multum_image& image, const std::string& name) {
  constexpr int kSideMax = 1 << 20;
  if (image.size < sizeof(multum_image))
    throw Error(ErrorCode::kUsage, name + ": the field `size` is " + std::to_string(image.size) +
                                       ", expected an image that MULTUM_IMAGE_INIT initialised");
  if (image.width < 1 || image.height < 1 || image.width > kSideMax || image.height > kSideMax)
    throw Error(ErrorCode::kUsage, fmt::format("{}: found {} x {} texels, expected 1 to {} per side", name, image.width,
                                               image.height, kSideMax));
  if (image.channels < 1 || image.channels > 4)
    throw Error(ErrorCode::kUsage, fmt::format("{}: found {} channels, expected 1 to 4", name, image.channels));
  if (image.pixels == nullptr) throw Error(ErrorCode::kUsage, name + ": pixels is NULL, expected pixels");
  MemoryImage result;
  result.width = image.width;
  result.height = image.height;
  result.channel_names = channel_names(image.channels);
  result.base_type = base_type_of(image, name);
  result.texel_bytes = static_cast<std::size_t>(image.channels) * number_bytes(result.base_type);
  const auto row = static_cast<std::ptrdiff_t>(result.texel_bytes) * image.width;
  result.row_bytes = image.row_bytes == 0 ? row : image.row_bytes;
  if (std::abs(result.row_bytes) < row)
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: row_bytes is {}, expected at least {}", name, image.row_bytes, row));
  result.first_row = static_cast<const std::byte*>(image.pixels);
  return result;
}

// The names of the maps of a job. Images in memory keep their names until the object ends.
class JobMaps {
 public:
  JobMaps(const multum_maps* maps, const char* function) {
    require(maps, function, "maps", "the maps of a material");
    if (maps->size < sizeof(multum_maps))
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: the field `size` of maps is {}, expected maps that MULTUM_MAPS_INIT initialised",
                              function, maps->size));
    if ((maps->input == nullptr) == (maps->normals == nullptr))
      throw Error(ErrorCode::kUsage,
                  fmt::format("{}: found {}, expected either a file (maps.input) or an image in memory (maps.normals)",
                              function, maps->input == nullptr ? "neither" : "both"));
    input_ = maps->input == nullptr ? add(*maps->normals, "normals") : maps->input;
    if (maps->albedo != nullptr) albedo_ = add(*maps->albedo, "albedo");
    if (maps->roughness != nullptr) roughness_ = add(*maps->roughness, "roughness");
    if (maps->weights != nullptr) weights_ = add(*maps->weights, "weights");
  }

  const std::string& input() const { return input_; }
  const std::string& albedo() const { return albedo_; }
  const std::string& roughness() const { return roughness_; }
  const std::string& weights() const { return weights_; }

  /// If there is an image in memory, uses it in place of the file that the settings name.
  static void choose(std::string& file, const std::string& image, const char* name) {
    if (image.empty()) return;
    if (!file.empty())
      throw Error(ErrorCode::kUsage,
                  fmt::format("{} is given both as a setting ({}) and as an image in memory, expected only one of them",
                              name, file));
    file = image;
  }

 private:
  std::string add(const multum_image& image, const std::string& name) {
    names_.push_back(std::make_unique<MemoryImageName>(memory_image(image, name), name));
    return names_.back()->path();
  }

  std::vector<std::unique_ptr<MemoryImageName>> names_;
  std::string input_, albedo_, roughness_, weights_;
};

BakeJob bake_job(const JobMaps& maps, const ParameterValues& parameters, const multum_values* values) {
  BakeJob job;
  job.threads = job.writing.threads = threads_of(values);
  check_scopes(parameters);
  check_exclusions(parameters);
  check_target_values(parameters);
  apply(parameters, job);
  apply_region(parameters, job);
  job.input = maps.input();
  JobMaps::choose(job.albedo, maps.albedo(), "albedo");
  JobMaps::choose(job.roughness, maps.roughness(), "roughness");
  JobMaps::choose(job.weights, maps.weights(), "weights");
  return job;
}

BakeReport run_bake(const BakeJob& job, const ParameterValues& parameters, Device& device, Progress* progress) {
  if (!has_target(parameters)) return bake_file(job, nullptr, device, progress);
  const ChosenBake chosen = bake_to_target(job, bake_target(parameters, find_viewer()), device, progress);
  check_met(job, chosen);
  return chosen.report;
}

}  // namespace
}  // namespace multum

using multum::Error;
using multum::ErrorCode;
using multum::guarded;

multum_status multum_bake(multum_device* device, const multum_maps* maps, const multum_values* values,
                          const char* output, const multum_callbacks* callbacks, multum_map** map,
                          multum_error** error) {
  return guarded(error, [&] {
    multum::require(device, "multum_bake", "device", "a device");
    if (output == nullptr) multum::require(map, "multum_bake", "map", "a place for the result, or an output");
    multum::ApiCall call(callbacks);
    const multum::JobMaps names(maps, "multum_bake");
    const multum::ParameterValues parameters = multum::values_of(values, multum::bake_parameters());
    multum::BakeJob job = multum::bake_job(names, parameters, values);
    std::unique_ptr<multum::WorkFolder> folder;
    if (output == nullptr) folder = multum::WorkFolder::make(std::filesystem::temp_directory_path().string());
    job.output = output == nullptr ? folder->path() + "/baked.ndf.exr" : output;
    const multum::NewFolders new_folders;
    multum::make_folder_of(job.output);
    const multum::DeviceUse use(*device, call.progress());
    const multum::BakeReport report = multum::run_bake(job, parameters, device->device, call.progress());
    if (map == nullptr) return;
    auto made = std::make_unique<multum_map>(job.output, std::move(folder));
    made->set_report(report.to_json());
    *map = made.release();
  });
}

multum_status multum_export(multum_device* device, const multum_maps* maps, const multum_values* values,
                            const char* output, const multum_callbacks* callbacks, multum_text** report,
                            multum_error** error) {
  return guarded(error, [&] {
    multum::require(device, "multum_export", "device", "a device");
    multum::require(output, "multum_export", "output", "a folder or a file to write");
    multum::ApiCall call(callbacks);
    const multum::JobMaps names(maps, "multum_export");
    const multum::ParameterValues parameters = multum::values_of(values, multum::export_parameters());
    if (parameters.flag("lobes") || !parameters.text("page").value_or("").empty())
      throw Error(ErrorCode::kUsage,
                  "lobes or page is set, expected neither, because only the program can write these files");
    if (!names.albedo().empty() || !names.weights().empty())
      throw Error(
          ErrorCode::kUsage,
          "found an albedo or weights, expected only normals and roughness, because an export stores nothing else");
    multum::check_exclusions(parameters);
    multum::ExportJob job;
    job.threads = multum::threads_of(values);
    multum::apply(parameters, job);
    job.input = names.input();
    multum::JobMaps::choose(job.roughness, names.roughness(), "roughness");
    job.output = output;
    const multum::NewFolders new_folders;
    multum::make_folder_of(job.output);
    const multum::DeviceUse use(*device, call.progress());
    const multum::ExportReport made = multum::export_file(job, device->device, call.progress());
    if (report != nullptr) *report = new multum_text{made.to_json(job)};
  });
}

multum_status multum_convert_model(multum_device* device, const char* input, const multum_values* values,
                                   const char* output, const multum_callbacks* callbacks, multum_text** report,
                                   multum_error** error) {
  return guarded(error, [&] {
    multum::require(device, "multum_convert_model", "device", "a device");
    multum::require(input, "multum_convert_model", "input", "the name of a model");
    multum::require(output, "multum_convert_model", "output", "the name of a file to write");
    multum::ApiCall call(callbacks);
    const multum::ParameterValues parameters = multum::values_of(values, multum::gltf_parameters());
    multum::GltfJob job;
    job.threads = multum::threads_of(values);
    multum::check_exclusions(parameters);
    multum::apply(parameters, job);
    job.input = input;
    job.output = output;
    const multum::NewFolders new_folders;
    multum::make_folder_of(job.output);
    const multum::DeviceUse use(*device, call.progress());
    const multum::GltfReport made = multum::convert_gltf(job, device->device, call.progress());
    if (report != nullptr) *report = new multum_text{made.to_json(job)};
  });
}

multum_status multum_measure(multum_device* device, const char* baked, const multum_maps* maps,
                             const multum_values* values, const multum_callbacks* callbacks, multum_text** errors,
                             multum_error** error) {
  return guarded(error, [&] {
    multum::require(device, "multum_measure", "device", "a device");
    multum::require(baked, "multum_measure", "baked", "the name of a baked file");
    multum::require(errors, "multum_measure", "errors", "a place for the result");
    multum::ApiCall call(callbacks);
    const multum::JobMaps names(maps, "multum_measure");
    const multum::ParameterValues parameters = multum::values_of(values, multum::bake_parameters());
    multum::BakeJob job = multum::bake_job(names, parameters, values);
    job.output = baked;
    const multum::DeviceUse use(*device, call.progress());
    const multum::BakedCheck check = multum::check_baked_file(job, device->device, call.progress());
    if (!check.damage.empty()) throw Error(ErrorCode::kVerification, std::string(baked) + ": " + check.damage);
    *errors = new multum_text{multum::measured_error_json(check.measured.rows, check.measured.footprint_errors)};
  });
}
