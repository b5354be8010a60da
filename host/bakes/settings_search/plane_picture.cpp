// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/settings_search/plane_picture.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/viewer_process.h"

namespace multum {
namespace {

// Two temporary files.
class PictureFiles {
 public:
  explicit PictureFiles(const std::string& beside) : sheet(beside + ".sheet.png"), report(beside + ".view.json") {}
  PictureFiles(const PictureFiles&) = delete;
  PictureFiles& operator=(const PictureFiles&) = delete;
  ~PictureFiles() {
    std::error_code ignored;
    std::filesystem::remove(sheet, ignored);
    std::filesystem::remove(report, ignored);
  }
  const std::string sheet, report;
};

}  // namespace

const nlohmann::json& own_picture(const nlohmann::json& report) {
  if (report.is_object() && report.contains("pictures"))
    for (const nlohmann::json& picture : report.at("pictures"))
      if (picture.at("name") == "multum") return picture;
  throw Error(ErrorCode::kEnvironment, "the report of multum-view does not list the picture of the baked map");
}

double draw_plane(const BakeJob& job, const TargetBrdf& brdf, const PlaneViewer& viewer, Progress* progress) {
  const PictureFiles files(job.output);
  std::vector<std::string> command = {viewer.program,
                                      job.output,
                                      "-o",
                                      files.sheet,
                                      "--report",
                                      files.report,
                                      "--source",
                                      job.input,
                                      "--context",
                                      viewer.context,
                                      "--decode",
                                      viewer.decode,
                                      "--compare",
                                      "reference",
                                      "--reference-texels",
                                      job.surface == MapSurface::kInterpolated ? "interpolated" : "nearest",
                                      "--samples",
                                      fmt::format("{}", viewer.samples)};
  if (job.roughness.empty()) command.insert(command.end(), {"--brdf", brdf.text});
  else command.insert(command.end(), {job.roughness_is_gloss ? "--gloss" : "--roughness", job.roughness});
  run_viewer(command, "drawing " + job.output, progress);
  std::ifstream file(files.report);
  const nlohmann::json report = nlohmann::json::parse(file, nullptr, false);
  return own_picture(report).at("relative_l1").get<double>();
}

}  // namespace multum
