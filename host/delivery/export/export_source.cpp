// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/export_source.h"

#include <fmt/format.h>

#include <cstdint>
#include <utility>

#include "host/formats/asset/baked_file.h"
#include "host/formats/image/normals/flat_map.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/log.h"

namespace multum {
namespace {

ChannelFile channel_file(const std::string& text) { return text.empty() ? ChannelFile{} : parse_channel_file(text); }

LobeMaterialFiles material_files_of(const ExportJob& job) {
  LobeMaterialFiles files{channel_file(job.roughness), channel_file(job.occlusion), channel_file(job.metalness)};
  files.roughness.is_gloss = job.roughness_is_gloss;
  return files;
}

// Returns the lobes that are measured together with the export, or none if the input has no vMF lobes or begins at
// another level. A file that the job names explicitly must contain such lobes.
std::unique_ptr<BakedLobes> compared_lobes(const ExportJob& job, const NormalMapRows& map, InputHashes& hashes) {
  if (!job.measure || (job.lobes.empty() && !is_baked_name(job.input))) return nullptr;
  if (job.lobes.empty()) {
    // The lobes describe the texels, not the surface between the texels.
    if (job.surface == MapSurface::kInterpolated) return nullptr;
    if (!representation_info(read_baked_header(job.input).representation).has_kappa) return nullptr;
    return std::make_unique<BakedLobes>(job.input, job.accuracy.levels);
  }
  auto lobes = std::make_unique<BakedLobes>(job.lobes, job.accuracy.levels);
  if (lobes->surface() != map_surface_name(job.surface))
    throw Error(ErrorCode::kInput, fmt::format("{}: was baked with --surface {}, expected {} as in this export",
                                               job.lobes, lobes->surface(), map_surface_name(job.surface)));
  const int width = map.normals.width(), height = map.normals.height();
  if (lobes->width() != width || lobes->height() != height)
    throw Error(ErrorCode::kInput, fmt::format("{}: was baked from a map of {} x {} texels, expected {} x {} as in {}",
                                               job.lobes, lobes->width(), lobes->height(), width, height, job.input));
  if (!is_baked_name(job.input) && lobes->source_hash() != hashes.hash(job.input))
    throw Error(ErrorCode::kInput,
                fmt::format("{}: was baked from another map; expected a bake of {}", job.lobes, job.input));
  return lobes;
}

}  // namespace

std::vector<std::string> input_files(const ExportJob& job) {
  std::vector<std::string> inputs = {job.input};
  const LobeMaterialFiles files = material_files_of(job);
  for (const ChannelFile& file : {files.roughness, files.occlusion, files.metalness})
    if (!file.path.empty()) inputs.push_back(file.path);
  if (!job.lobes.empty()) inputs.push_back(job.lobes);
  return inputs;
}

OneLobeInputs ExportSource::inputs(const ExportJob& job) const {
  OneLobeInputs inputs;
  inputs.normals = &map.normals;
  if (surface) inputs.surface = &*surface;
  if (material) inputs.material = &material->planes;
  inputs.has_roughness = !job.roughness.empty();
  inputs.has_occlusion = !job.occlusion.empty();
  inputs.has_metalness = !job.metalness.empty();
  inputs.memory_bytes = job.memory_bytes / 2;
  inputs.threads = job.threads;
  return inputs;
}

ExportSource read_export_source(const ExportJob& job, const std::string& folder, Progress* progress) {
  auto hashes = std::make_unique<InputHashes>();
  for (const std::string& file : input_files(job)) hashes->note(file);
  // Half of the memory is for the fit. The other half is for normals, surface and material.
  const bool has_surface = job.surface == MapSurface::kInterpolated;
  const SpillPolicy spill = {job.scratch_folder.empty() ? folder : job.scratch_folder,
                             static_cast<std::int64_t>(job.memory_bytes / (has_surface ? 6 : 4))};
  ExportSource source{is_baked_name(job.input)
                          ? read_baked_normals(job.input, spill, progress)
                          : read_normal_map_rows(job.input, job.reading, spill, job.threads, progress),
                      std::nullopt, std::nullopt, nullptr, std::move(hashes)};
  source.lobes = compared_lobes(job, source.map, *source.hashes);
  if (!job.roughness.empty() || !job.occlusion.empty() || !job.metalness.empty())
    source.material = read_lobe_material(material_files_of(job), source.map.normals.width(),
                                         source.map.normals.height(), spill, job.threads);
  for (const std::string& file : input_files(job)) source.hashes->check_unchanged(file);
  if (has_surface)
    source.surface = surface_normals(source.map.normals, {source.map.report.wrap_s, source.map.report.wrap_t}, spill,
                                     job.threads, progress);
  if (is_baked_name(job.input))
    if (const std::string note = flat_note(flatness_of(source.map.normals)); !note.empty())
      source.map.report.warnings.push_back(note);
  const NormalMapReport& found = source.map.report;
  log_info(fmt::format("{}: {} x {}, {}; {}", job.input, source.map.normals.width(), source.map.normals.height(),
                       found.encoding, found.encoding_reason));
  for (const std::string& warning : found.warnings) log_warning(job.input, warning);
  if (source.material && source.material->roughness) {
    log_info(fmt::format("{}: {}", material_files_of(job).roughness.path, source.material->roughness->to_text()));
    for (const std::string& warning : source.material->roughness->warnings) log_named_warning(warning);
  }
  if (source.material)
    for (const std::string& warning : source.material->warnings) log_named_warning(warning);
  return source;
}

}  // namespace multum
