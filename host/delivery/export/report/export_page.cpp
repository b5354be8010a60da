// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/report/export_page.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "host/delivery/export/report/frame_video.h"
#include "host/delivery/export/report/surface_frames.h"
#include "host/formats/image/files/png_writer.h"
#include "host/foundation/base/base64.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/output_paths.h"
#include "host/foundation/base/files/work_folder.h"
#include "host/foundation/base/log.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/size_of.h"
#include "host/foundation/base/version.h"
#include "host/foundation/html/html_page.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kTileColumns = 3;

std::string png_of(const std::vector<std::uint8_t>& grey, const std::string& folder) {
  const std::string path = folder + "/picture.png";
  Png8Image image{kFrameSide, kFrameSide, 1, grey};
  write_png8(path, image);
  return bytes_of_file(path);
}

// Places the reference and all models of a frame side by side, row by row.
std::vector<std::uint8_t> tiled(const std::vector<std::vector<std::uint8_t>>& pictures, int rows) {
  const std::size_t side = size_of(kFrameSide), width = side * kTileColumns;
  std::vector<std::uint8_t> tiles(width * side * size_of(rows));
  for (std::size_t p = 0; p < pictures.size(); ++p) {
    const std::size_t left = p % kTileColumns * side, top = p / kTileColumns * side;
    for (std::size_t y = 0; y < side; ++y)
      std::copy_n(pictures[p].begin() + static_cast<std::ptrdiff_t>(y * side), side,
                  tiles.begin() + static_cast<std::ptrdiff_t>((top + y) * width + left));
  }
  return tiles;
}

// Returns one video with all motions in sequence, or an empty result if ffmpeg is missing.
std::string video_of(const SurfaceStudy& study, const std::string& page, const std::string& folder) {
  VideoFrames video;
  const int rows = (static_cast<int>(study.ids.size()) + 1 + kTileColumns - 1) / kTileColumns;
  video.width = kFrameSide * kTileColumns;
  video.height = kFrameSide * rows;
  for (const StudyMotion& motion : study.motions)
    for (const auto& pictures : motion.frames) video.frames.push_back(tiled(pictures, rows));
  try {
    return encode_webm(video, folder);
  } catch (const Error& error) {
    log_warning(page, std::string("has no moving pictures: ") + error.what());
    return "";
  }
}

Json study_values(const SurfaceStudy& study) {
  Json json = {{"distances", Json::array()}, {"motions", Json::array()}};
  for (const StudyDistance& distance : study.distances) {
    Json one = {{"level", distance.level}, {"models", Json::object()}};
    for (std::size_t m = 0; m < study.ids.size(); ++m)
      one["models"][study.ids[m]] = {{"error", distance.pictures[m + 1].error},
                                     {"energy", distance.pictures[m + 1].energy}};
    json["distances"].push_back(one);
  }
  for (const StudyMotion& motion : study.motions) {
    Json one = {{"id", motion.id},
                {"frames", motion.frame_count},
                {"reference_change", motion.reference_change},
                {"models", Json::object()}};
    for (std::size_t m = 0; m < study.ids.size(); ++m)
      one["models"][study.ids[m]] = {{"error", motion.models[m].error},
                                     {"flicker", motion.models[m].flicker},
                                     {"change", motion.models[m].change}};
    json["motions"].push_back(one);
  }
  return json;
}

}  // namespace

std::string study_json(const SurfaceStudy& study) { return study_values(study).dump(); }

void write_export_page(const ExportJob& job, const ExportReport& report, const std::string& path, Device& device,
                       Progress* progress) {
  check_writable(path);
  const std::unique_ptr<WorkFolder> scratch = WorkFolder::take(partial_folder_of(path));
  if (!scratch) throw Error(ErrorCode::kEnvironment, path + ": another process is writing this page");
  scratch->clear();
  const SurfaceStudy study = study_surface(job, scratch->path(), device, progress);
  Json json = study_values(study);
  for (std::size_t d = 0; d < study.distances.size(); ++d)
    for (std::size_t p = 0; p <= study.ids.size(); ++p)
      json["distances"][d]["pictures"][p == 0 ? "reference" : study.ids[p - 1]] =
          encode_base64(png_of(study.distances[d].pictures[p].grey, scratch->path()));
  for (std::size_t m = 0; m < study.ids.size(); ++m) json["names"][study.ids[m]] = study.names[m];
  const std::string map = text_of_path(fs::path(job.input).filename().string());
  json["title"] = "One lobe per texel: " + map;
  json["map"] = map;
  json["software"] = software_version();
  json["report"] = Json::parse(report.to_json(job));
  progress_stage(progress, "encode");
  json["video"] = encode_base64(video_of(study, path, scratch->path()));
  const auto& files = export_templates();
  write_text_file(path, html_page({files.at("export.html"), files.at("export.css"), files.at("export.js")}, json));
}

}  // namespace multum
