// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/batch/export_record.h"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/delivery/export/batch/export_batch.h"
#include "host/delivery/export/export_key.h"
#include "host/formats/image/normals/tile_set.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

// Returns null if no record can be read.
Json read_record(const std::string& path) {
  const Json record = Json::parse(json_of_file(path).value_or(""), nullptr, false);
  const bool has_tiles_text = record.is_object() && (!record.contains("tiles") || record["tiles"].is_string());
  return has_tiles_text && record.contains("key") && record.contains("files") && record["files"].is_object() ? record
                                                                                                             : Json();
}

// Accepts only names in the record's own folder, so that no path can lead out of the folder.
bool is_plain_name(const std::string& name) { return !name.empty() && fs::path(name).filename() == name; }

}  // namespace

std::string export_record_file(const ExportJob& job) {
  const ExportPlace place = export_place(job.output);
  return place.folder + "/." + (place.stem.empty() ? "" : place.stem + ".") + "multum-export";
}

ExportState find_export_state(const ExportJob& job) {
  const std::string path = export_record_file(job);
  const Json record = read_record(path);
  if (record.is_null()) return {ExportFinding::kMissing, "there is no record of this export"};
  const std::string folder = fs::path(path).parent_path().string();
  const Json key = export_key(job);
  if (record["key"] != key) {
    for (const auto& [part, value] : key.items())
      if (!record["key"].is_object() || !record["key"].contains(part) || record["key"][part] != value)
        return {ExportFinding::kStale, fmt::format("made with other {}", part)};
    return {ExportFinding::kStale, "made with other settings"};
  }
  const NormalMapSettings& reading = job.reading;
  if (const std::string tiles = record.value("tiles", "");
      !tiles.empty() && reading.tiles != nullptr &&
      !tiles_are_unchanged(tiles, *reading.tiles, reading.tile, reading.fix_nan))
    return {ExportFinding::kStale, "other tiles of its set that affect its borders or its green axis have changed"};
  for (const auto& [text, hash] : record["files"].items()) {
    const std::string name = path_of_text(text);
    if (!is_plain_name(name))
      return {ExportFinding::kStale, fmt::format("{}: the record names files in other folders", path)};
    const std::string file = folder + "/" + name;
    std::error_code none;
    if (!fs::exists(file, none)) return {ExportFinding::kMissing, fmt::format("there is no {}", name)};
    if (!fs::is_regular_file(file, none) || hash != Json(hash_file(file)))
      return {ExportFinding::kDamaged, fmt::format("{} differs from the written file", name)};
  }
  return {ExportFinding::kInPlace, ""};
}

void write_export_record(const ExportJob& job, const ExportReport& report) {
  Json record = {{"key", export_key(job)}, {"files", Json::object()}};
  if (!report.input.tiles.empty()) record["tiles"] = report.input.tiles;
  for (const std::string& file : report.files)
    record["files"][text_of_path(fs::path(file).filename().string())] = hash_file(file);
  write_text_file(export_record_file(job), json_text(record, 1) + "\n");
}

}  // namespace multum
