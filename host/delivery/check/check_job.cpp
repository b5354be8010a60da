// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/check/check_job.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "host/delivery/check/mapped_surface.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/reading_parameters.h"
#include "host/formats/mesh/gltf_document.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/parameters/check_parameters.h"

namespace multum {
namespace {

const std::vector<double> kDistances = {1.0, 2.0, 5.0, 10.0, 25.0, 50.0};  // metres, for the roughness of the sentence
const std::vector<double> kOtherDistances = {2.0, 5.0, 25.0}, kQuickDistances = kOtherDistances;
constexpr double kOtherRoughness[] = {0.1, 0.3, 0.6};
constexpr std::size_t kPixels = 1000, kQuickPixels = 150, kQuickFormPixels = 40;

// Glints of smooth surfaces are rare and bright, so they need more pixels.
std::size_t pixels_for(double roughness) { return roughness < 0.2 ? 5 * kPixels : kPixels; }

GainVerdict measured(const std::string& name, const GainSurface& surface, double roughness,
                     const GainSettings& settings, Device& device, Progress* progress) {
  GainVerdict made{name, "", measure_gain(device, surface, settings, progress), std::nullopt};
  if (!surface.has_roughness) made.roughness = roughness;
  if (made.measured.empty()) made.kept = "from 1 m away, its surface is smaller than a few pixels";
  return made;
}

// Returns settings for the roughness of the sentence.
GainSettings settings_of(const CheckJob& job, double roughness, const std::vector<double>& distances) {
  GainSettings settings;
  settings.engine = job.engine;
  settings.threads = job.threads;
  settings.cases = {{roughness, distances, pixels_for(roughness)}};
  return settings;
}

std::vector<GainVerdict> check_model(const CheckJob& job, Device& device, Progress* progress) {
  const GltfAsset asset = read_gltf_asset(job.input);
  const auto folder = WorkFolder::make(std::filesystem::temp_directory_path().string());
  std::vector<GainVerdict> made;
  for (const ModelSurface& one : surfaces_of_model(asset, folder->path(), kDistances, job.threads, progress)) {
    const std::string name = job.input + ": " + one.material;
    if (one.surface)
      made.push_back(
          measured(name, *one.surface, one.roughness, settings_of(job, one.roughness, kDistances), device, progress));
    else made.push_back({name, one.kept, {}, std::nullopt});
  }
  if (made.empty()) made.push_back({job.input, "has no material with a normal map: keep your mips", {}, std::nullopt});
  return made;
}

}  // namespace

void apply(const ParameterValues& values, CheckJob& job) {
  apply_reading(values, job.reading);
  if (const auto name = values.text("for")) job.engine = *find_choice(kEngines, *name);
  if (const auto metres = values.number("tile_size")) job.tile_metres = *metres;
  if (const auto roughness = values.number("base_roughness")) job.base_roughness = *roughness;
  job.is_metal = values.flag("metal");
}

std::vector<std::string> files_to_check(const std::string& folder) {
  constexpr const char* kTypes[] = {"png", "jpg", "jpeg", "webp", "tif", "tiff", "exr"};
  std::vector<std::string> made;
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string path = at->path().string(), extension = lower_extension(path);
    std::error_code ignored;
    if (!at->is_regular_file(ignored)) continue;
    const bool is_image = std::find(std::begin(kTypes), std::end(kTypes), extension) != std::end(kTypes) &&
                          !path.ends_with(".ndf.exr") && map_by_name(path) == NamedMap::kUnknown;
    if (is_image || is_gltf_name(path)) made.push_back(path);
  }
  if (error) throw Error(ErrorCode::kInput, folder + ": cannot be listed: " + error.message());
  std::sort(made.begin(), made.end());
  return made;
}

std::vector<GainVerdict> check_file(const CheckJob& job, Device& device, Progress* progress) {
  progress_stage(progress, "check");
  if (is_gltf_name(job.input)) return check_model(job, device, progress);
  const NormalMapRows map = read_normal_map_rows(job.input, job.reading, {}, job.threads, progress);
  if (job.only_normals && map.report.is_height_field)
    throw Error(ErrorCode::kInput, job.input +
                                       ": contains heights or a picture, expected normals; to check a height "
                                       "field, name it");
  for (const std::string& warning : map.report.warnings) log_warning(job.input, warning);
  GainSurface surface = surface_of_mosaic(mosaic_of(map.normals, nullptr, {}), job.tile_metres);
  surface.metalness = job.is_metal ? 1.0 : 0.0;
  GainSettings settings = settings_of(job, job.base_roughness, kDistances);
  for (const double roughness : kOtherRoughness)
    if (roughness != job.base_roughness) settings.cases.push_back({roughness, kOtherDistances, pixels_for(roughness)});
  return {measured(job.input, surface, job.base_roughness, settings, device, progress)};
}

GainVerdict quick_verdict(const CheckJob& job, const MapMosaic& mosaic, StartMemory* starts, Device& device,
                          Progress* progress) {
  GainSurface surface = surface_of_mosaic(mosaic, job.tile_metres);
  surface.has_roughness = surface.has_roughness || job.has_roughness;
  surface.has_metalness = job.has_metalness;
  surface.metalness = job.is_metal || job.has_metalness ? 1.0 : 0.0;
  GainSettings settings = settings_of(job, job.base_roughness, kQuickDistances);
  settings.cases.front().pixels_per_view = kQuickPixels;
  settings.form_pixels = kQuickFormPixels;
  settings.starts = starts;
  return measured(job.input, surface, job.base_roughness, settings, device, progress);
}

}  // namespace multum
