// SPDX-License-Identifier: Apache-2.0
#include "host/export/batch/export_record.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/base/files/content_hash.h"
#include "host/base/version.h"
#include "host/export/batch/export_batch.h"
#include "host/opencl/program_cache.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// An optional's value, or null.
template <typename Value>
Json json_of(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

// Everything that decides a byte of the files.
Json export_key(const ExportJob& job) {
  const NormalMapSettings& reading = job.reading;
  Json key = {{"software", software_version()},
              {"kernels", kernel_sources_hash()},
              {"reading",
               {reading.bump_format, json_of(reading.green), json_of(reading.is_signed), json_of(reading.two_channel),
                reading.height_scale, reading.normal_scale, reading.wrap_s, reading.wrap_t, reading.wrap_s_origin,
                reading.wrap_t_origin, reading.fix_nan}},
              {"lobe",
               {job.lobe.is_anisotropic, job.lobe.is_fast,
                job.roughness.empty() ? Json(job.lobe.base_roughness) : Json(), job.lobe.iteration_count}},
              {"gloss", job.roughness_is_gloss},
              {"format", json_of(job.format)},
              {"texels", json_of(job.texels)},
              {"zstd", job.zstd_level},
              {"roughness_alone", job.has_roughness_alone}};
  ExportJob made_of = job;
  made_of.lobes.clear();  // compared with, and no more
  for (const std::string& file : input_files(made_of)) key["inputs"].push_back(hash_file(file));
  // Which channel of them.
  for (const std::string& named : {job.roughness, job.occlusion, job.metalness})
    key["channels"].push_back(named.empty() ? Json() : Json(parse_channel_file(named).channel));
  return key;
}

// Null: there is none that can be read.
Json read_record(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  const Json record = Json::parse(text.str(), nullptr, false);
  return record.is_object() && record.contains("key") && record.contains("files") && record["files"].is_object()
             ? record
             : Json();
}

// Names in a record are those of its own folder, and no way out of it.
bool is_plain_name(const std::string& name) { return !name.empty() && fs::path(name).filename() == name; }

}  // namespace

std::string export_record_file(const ExportJob& job) {
  const ExportPlace place = export_place(job.output);
  return place.folder + "/." + (place.stem.empty() ? "" : place.stem + ".") + "multum-export";
}

ExportState find_export_state(const ExportJob& job) {
  const std::string path = export_record_file(job);
  const Json record = read_record(path);
  if (record.is_null()) return {ExportFinding::kMissing, "there is no record of it"};
  const std::string folder = fs::path(path).parent_path().string();
  const Json key = export_key(job);
  if (record["key"] != key) {
    for (const auto& [part, value] : key.items())
      if (!record["key"].is_object() || !record["key"].contains(part) || record["key"][part] != value)
        return {ExportFinding::kStale, fmt::format("made with other {}", part)};
    return {ExportFinding::kStale, "made otherwise"};
  }
  for (const auto& [name, hash] : record["files"].items()) {
    if (!is_plain_name(name)) return {ExportFinding::kStale, fmt::format("{}: names files elsewhere", path)};
    const std::string file = folder + "/" + name;
    std::error_code none;
    if (!fs::exists(file, none)) return {ExportFinding::kMissing, fmt::format("there is no {}", name)};
    if (!fs::is_regular_file(file, none) || hash != Json(hash_file(file)))
      return {ExportFinding::kDamaged, fmt::format("{} is not what was written", name)};
  }
  return {ExportFinding::kInPlace, ""};
}

void write_export_record(const ExportJob& job, const std::vector<std::string>& files) {
  Json record = {{"key", export_key(job)}, {"files", Json::object()}};
  for (const std::string& file : files) record["files"][fs::path(file).filename().string()] = hash_file(file);
  write_text_file(export_record_file(job), record.dump(1) + "\n");
}

}  // namespace multum
