// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/batch/export_batch.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>

#include "host/formats/image/normals/reading_parameters.h"
#include "host/formats/image/normals/tile_set.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/udim_set.h"
#include "host/foundation/parameters/engine_presets.h"
#include "host/foundation/parameters/export_parameters.h"

namespace multum {
namespace {

// Returns the output name of a map in a folder for several maps. File names begin with this name. If each level is an
// image, it is the name of a folder.
std::string output_suffix(const ExportJob& job) {
  const MaterialFormat format = format_of(job);
  if (format == MaterialFormat::kKtx2) return ".ktx2";
  return format == MaterialFormat::kDds ? ".dds" : "";
}

}  // namespace

void apply(const ParameterValues& values, ExportJob& job) {
  apply_reading(values, job.reading);
  job.surface = map_surface(values).value_or(job.surface);
  job.lobe.base_roughness = values.number("base_roughness").value_or(job.lobe.base_roughness);
  job.lobe.is_anisotropic = job.lobe.is_anisotropic || values.flag("anisotropy");
  job.lobe.is_fast = job.lobe.is_fast || values.flag("fast");
  if (const auto form = values.choice("form", kMaterialForms)) job.form = form;
  if (const auto engine = values.choice("for", kEngines)) {
    job.engine = engine;
    const EnginePreset& preset = preset_of(*engine);
    job.packing = preset.packing;
    job.names = preset.names;
    job.sides = preset.sides;
    job.write_green = preset.green;
  }
  job.roughness = values.text("roughness").value_or(job.roughness);
  if (const auto gloss = values.text("gloss")) job.roughness = *gloss, job.roughness_is_gloss = true;
  job.occlusion = values.text("occlusion").value_or(job.occlusion);
  job.metalness = values.text("metalness").value_or(job.metalness);
  job.format = values.choice("format", kMaterialFormats);
  job.texels = values.choice("texels", kMaterialTexels);
  if (const auto level = values.integer("zstd")) job.zstd_level = level;
  job.packing = values.choice("packing", kMaterialPackings).value_or(job.packing);
  job.names = values.choice("names", kTextureNames).value_or(job.names);
  job.sides = values.choice("sides", kSideRules).value_or(job.sides);
  job.write_green = values.choice("write_green", kGreenAxes).value_or(job.write_green);
  job.uastc_effort = values.integer("uastc_effort").value_or(job.uastc_effort);
  job.encoder = values.text("encoder").value_or(job.encoder);
  if (const auto bytes = values.bytes("memory")) job.memory_bytes = static_cast<std::uint64_t>(*bytes);
  job.lobes = values.text("beside").value_or(job.lobes);
  job.measure = job.measure && !values.flag("no_measure");
  job.force = job.force || values.flag("force");
  job.resume = job.resume || values.flag("resume");
  job.accuracy.finds_optimum = job.accuracy.finds_optimum || values.flag("optimum");
  job.accuracy.cells_per_level = values.integer("cells").value_or(job.accuracy.cells_per_level);
  job.report = values.text("report").value_or(job.report);
  job.scratch_folder = values.text("scratch").value_or(job.scratch_folder);
}

std::vector<ExportJob> make_export_jobs(const ExportJob& pattern, const std::vector<std::string>& inputs) {
  MULTUM_CHECK(!inputs.empty());
  if (inputs.size() == 1 && !has_udim(inputs[0])) {
    ExportJob job = pattern;
    job.input = inputs[0];
    return {job};
  }
  std::vector<ExportJob> jobs;
  std::map<std::string, std::string> taken;  // output -> input
  TileSets sets;
  for (const SetMap& map : maps_of_names(inputs)) {
    ExportJob job = pattern;
    job.input = map.path;
    sets.enter(map.set, map.tile, job.reading);
    if (!map.tile.empty())
      for (std::string ExportJob::*beside : kExportMapsBeside) job.*beside = with_tile(pattern.*beside, map.tile);
    job.output = place_of_map(pattern.output, map, output_suffix(pattern));
    job.report = place_of_map(pattern.report, map, ".json");
    const std::string name = std::filesystem::path(job.output).lexically_normal().string();
    const auto [other, is_new] = taken.emplace(name, map.path);
    if (!is_new)
      throw Error(ErrorCode::kUsage, name + ": both " + other->second + " and " + map.path + " would be written there");
    jobs.push_back(std::move(job));
  }
  return jobs;
}

int share_memory(const std::vector<ExportJob*>& jobs) {
  constexpr std::uint64_t kLeast = std::uint64_t{64} << 20;  // holds a map of 1024 x 1024
  const ExportJob& first = *jobs.front();
  const std::uint64_t most =
      std::min<std::uint64_t>(jobs.size(), static_cast<std::uint64_t>(std::max(1, first.threads)));
  const std::uint64_t at_once = std::clamp<std::uint64_t>(first.memory_bytes / kLeast, 1, most);
  for (ExportJob* job : jobs) job->memory_bytes /= at_once;
  return static_cast<int>(at_once);
}

}  // namespace multum
