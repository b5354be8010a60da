// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/bake_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/formats/image/colour_map.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/processes/machine.h"

namespace multum {
namespace {

// Returns the size in bytes of the largest map that stays in memory. The limit is low if the job has a memory limit. A
// map of 4096 x 4096 texels needs 192 MiB, and writing it to a scratch file would take a fifth of the time of a plan.
// While the file is read, its 16-bit values need another 96 MiB, which are freed before the bake needs the most memory.
std::int64_t map_bytes_in_memory(const BakeJob& job, MapReadings readings) {
  constexpr std::int64_t kLittle = std::int64_t{16} << 20, kDefault = std::int64_t{96} << 20;
  if (job.memory_bytes > 0) return kLittle;
  const std::int64_t much = std::max(kLittle, static_cast<std::int64_t>(machine_memory_bytes() / 32));
  return readings == MapReadings::kFew ? std::min(kDefault, much) : much;
}

// Colours are stored as 16-bit floats, except in float files. For float files, the limit is far below the largest
// float, so that neither sums of texels nor the measurement overflow.
void check_range(const BakeJob& job, float largest) {
  constexpr float kHalfMax = 65504.0f, kFloatMax = 1e15f;
  const bool is_float = job.encoding == StorageEncoding::kFloat;
  const float most = is_float ? kFloatMax : kHalfMax;
  if (largest > most)
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: found a colour value of {:g}, expected at most {:g}{}", job.albedo, largest, most,
                    is_float ? "" : ", the largest half float" + advice("; <data_format float> stores larger values")));
}

// Replaces texels with points of the surface.
void take_surface_points(const BakeJob& job, const SpillPolicy& spill, BakeSource& source, Progress* progress) {
  progress_stage(progress, "interpolate " + job.input);
  const MapWrap wrap = {source.map.report.wrap_s, source.map.report.wrap_t};
  source.map.normals = surface_normals(source.map.normals, wrap, spill, job.threads, progress);
  if (source.albedo) source.albedo = surface_values(*source.albedo, wrap, spill, job.threads, progress);
  if (source.weights)
    for (PlaneStore& planes : source.weights->rgb_planes)
      planes = surface_values(planes, wrap, spill, job.threads, progress);
}

}  // namespace

std::string scratch_folder(const BakeJob& job) {
  if (!job.scratch_folder.empty()) return job.scratch_folder;
  const std::filesystem::path folder = std::filesystem::path(job.output).parent_path();
  return folder.empty() ? "." : folder.string();
}

BakedHeader baked_header_of(const BakeJob& job, const BakeSource& source) {
  BakedHeader header;
  header.representation = job.representation;
  header.encoding = job.encoding;
  header.wrap_s = source.map.report.wrap_s;
  header.wrap_t = source.map.report.wrap_t;
  header.width = source.map.normals.width();
  header.height = source.map.normals.height();
  header.first_level = job.fitting.first_level;
  header.has_colours = source.albedo.has_value();
  header.weight_count = source.weights ? source.weights->count : 0;
  header.has_roughness = source.has_roughness();
  header.mean_cosine = static_cast<float>(source.mean_cosine);
  return header;
}

std::string reading_json(const BakeJob& job, const BakeSource& source) {
  const NormalMapReport& found = source.map.report;
  nlohmann::ordered_json json = {
      {"format", found.format},
      {"found", found.encoding},
      {"because", found.encoding_reason},
      {"wrap", fmt::format("{}, {}", wrap_mode_name(found.wrap_s), wrap_mode_name(found.wrap_t))}};
  const auto add_count = [&](const char* name, std::int64_t count) {
    if (count > 0) json[name] = count;
  };
  add_count("unused_texels", found.unused_texels);
  add_count("nonfinite_repaired", found.nonfinite_repaired);
  add_count("zero_length_repaired", found.zero_length_repaired);
  add_count("below_horizon_repaired", found.below_horizon_repaired);
  if (!source.albedo_format.empty()) json["albedo"] = source.albedo_format;
  add_count("albedo_clamped", source.albedo_clamped);
  if (source.roughness)
    json["roughness"] =
        (roughness_file(job).is_gloss ? "gloss, read as roughness = 1 - gloss: " : "") + source.roughness->to_text();
  for (const std::string& warning : found.warnings) json["doubts"].push_back(without_advice(warning));
  return json_text(json);
}

BakeSource read_bake_source(const BakeJob& job, MapReadings readings, Progress* progress) {
  for (const std::string& file : input_files(job)) job.hashes->note(file);
  const SpillPolicy spill = {scratch_folder(job), map_bytes_in_memory(job, readings)};
  BakeSource source{read_normal_map_rows(job.input, job.reading, spill, job.threads, progress), std::nullopt,
                    std::nullopt};
  const int width = source.map.normals.width(), height = source.map.normals.height();
  if (!job.albedo.empty()) {
    ColourRows albedo = read_albedo_rows(job.albedo, width, height, spill, job.threads);
    check_range(job, albedo.largest);
    source.albedo.emplace(std::move(albedo.planes));
    source.albedo_clamped = albedo.clamped_count;
    source.albedo_format = std::move(albedo.format);
    for (const std::string& note : albedo.notes) source.map_warnings.push_back(job.albedo + ": " + note);
  }
  if (!job.weights.empty()) {
    source.weights = read_weight_map(job.weights, width, height, spill, job.threads);
    for (const std::string& warning : source.weights->warnings) source.map_warnings.push_back(warning);
  }
  if (!job.roughness.empty()) {
    source.roughness = shorten_by_roughness(source.map.normals, roughness_file(job), spill, job.threads);
    source.mean_cosine = source.roughness->mean_cosine;
  }
  for (const std::string& file : input_files(job)) job.hashes->check_unchanged(file);
  if (job.surface == MapSurface::kInterpolated) take_surface_points(job, spill, source, progress);
  return source;
}

void note_source(const BakeSource& source, BakeReport& report) {
  report.input = source.map.report;
  report.albedo_clamped = source.albedo_clamped;
  report.roughness = source.roughness;
}

BakeSource read_source(const BakeJob& job, MapReadings readings, BakeReport& report, Progress* progress) {
  BakeSource source = read_bake_source(job, readings, progress);
  note_source(source, report);
  log_source(job, source);
  return source;
}

void log_source(const BakeJob& job, const BakeSource& source) {
  const NormalMapReport& found = source.map.report;
  log_info(fmt::format("{}: {} x {}, {}; {}", job.input, source.map.normals.width(), source.map.normals.height(),
                       found.encoding, found.encoding_reason));
  for (const std::string& warning : found.warnings) log_warning(job.input, warning);
  for (const std::string& warning : source.map_warnings) log_named_warning(warning);
  if (source.roughness) {
    const ChannelFile file = roughness_file(job);
    log_info(fmt::format("{}: {}{}", file.path, file.is_gloss ? "gloss, read as roughness = 1 - gloss: " : "",
                         source.roughness->to_text()));
    for (const std::string& warning : source.roughness->warnings) log_named_warning(warning);
  }
}

}  // namespace multum
