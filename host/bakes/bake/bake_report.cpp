// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/bake/bake_report.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numeric>

#include "host/bakes/accuracy/accuracy_table.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/messages/option_words.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

using Json = nlohmann::ordered_json;

Json accuracy_json(const std::vector<AccuracyRow>& rows) {
  Json list = Json::array();
  for (const AccuracyRow& row : rows)
    list.push_back({{"level", row.level},
                    {"point", accuracy_point_name(row.point)},
                    {"brdf", row.brdf.text()},
                    {"relative_l1", row.error},
                    {"confidence_95", row.confidence},
                    {"samples", row.sample_count},
                    {"all_texels", row.confidence == 0.0}});
  return list;
}

Json error_json(const std::vector<FootprintError>& errors) {
  Json list = Json::array();
  for (const FootprintError& one : errors)
    list.push_back({{"brdf", one.brdf.text()},
                    {"relative_l1", one.error},
                    {"confidence_95", one.confidence},
                    {"percentile_95", one.percentile_95},
                    {"worst_octave", one.worst_octave},
                    {"worst_octave_relative_l1", one.worst_octave_error},
                    {"footprints", one.sample_count}});
  return list;
}

// Returns one line if any texel was repaired, otherwise an empty string.
std::string repairs_text(const NormalMapReport& input) {
  if (input.nonfinite_repaired + input.zero_length_repaired + input.below_horizon_repaired + input.unused_texels == 0)
    return "";
  return fmt::format(
      "repaired source texels: {} were not finite, {} had zero length, {} were below the horizon; {} were black or had "
      "no data, and were read as flat\n",
      input.nonfinite_repaired, input.zero_length_repaired, input.below_horizon_repaired, input.unused_texels);
}

}  // namespace

std::string BakeReport::to_json() const {
  Json json;
  json["source"] = text_of_path(source);
  if (!shard.empty()) json["shard"] = shard;
  json["unchanged"] = unchanged;
  if (unchanged) return json_text(json, 2) + "\n";
  json["device"] = device;
  json["input"] = {{"format", input.format},
                   {"encoding", input.encoding},
                   {"reason", input.encoding_reason},
                   {"warnings", with_advice(input.warnings)},
                   {"unused_texels", input.unused_texels},
                   {"nonfinite_repaired", input.nonfinite_repaired},
                   {"zero_length_repaired", input.zero_length_repaired},
                   {"below_horizon_repaired", input.below_horizon_repaired}};
  json["albedo_clamped"] = albedo_clamped;
  if (roughness)
    json["roughness"] = {{"least", roughness->least},
                         {"mean", roughness->mean},
                         {"most", roughness->most},
                         {"share_at_0", roughness->share_zero},
                         {"share_at_1", roughness->share_one},
                         {"warnings", with_advice(roughness->warnings)}};
  json["stages"] = Json::array();
  for (const StageTime& stage : stages) json["stages"].push_back({{"name", stage.name}, {"seconds", stage.seconds}});
  json["plan"] = plan();
  json["rows_resumed"] = rows_resumed;
  json["binning"] = {{"seconds", fit.binning_seconds}, {"launches", fit.binning_launches}};
  json["round_seconds"] = output.round_seconds;
  json["write_wait_seconds"] = output.write_wait_seconds;
  json["start"] = {{"seconds", fit.start_seconds}, {"tried", fit.starts_tried}, {"launches", fit.start_launches}};
  json["levels"] = Json::array();
  for (const LevelReport& level : fit.levels)
    json["levels"].push_back({{"level", level.level},
                              {"width", level.width},
                              {"height", level.height},
                              {"seconds", level.seconds},
                              {"launches", level.launches}});
  json["launches"] = launches;
  if (!launch_seconds.empty()) json["launch_seconds"] = launch_seconds;
  json["transfers"] = {{"uploads", transfers.uploads},
                       {"upload_bytes", transfers.upload_bytes},
                       {"downloads", transfers.downloads},
                       {"download_bytes", transfers.download_bytes}};
  json["device_bytes_peak"] = device_bytes_peak;
  json["builds"] = builds;
  json["programs"] =
      std::accumulate(builds.begin(), builds.end(), 0, [](int sum, const auto& build) { return sum + build.second; });
  json["counts"] = {{"lobes", fit.lobe_count_total},
                    {"nonfinite", fit.nonfinite},
                    {"kappa_clamped", fit.kappa_clamped},
                    {"dead_lobes", fit.dead_lobes},
                    {"undirected_lobes", fit.undirected_lobes},
                    {"slopes_limited", average.slopes_limited},
                    {"unrepresentable", output.unrepresentable}};
  json["unrepresentable_share"] = output.unrepresentable_share;
  json["error"] = error_json(error);
  if (picture_error) json["picture_error"] = *picture_error;
  json["measured_error"] = accuracy_json(accuracy);
  if (!choice.empty()) json["choice"] = choice;
  return json_text(json, 2) + "\n";
}

double BakeReport::bake_seconds() const {
  double seconds = 0.0;
  for (const StageTime& stage : stages)
    if (stage.name != "choose" && stage.name != "measure") seconds += stage.seconds;
  return seconds;
}

std::string BakeReport::to_text(bool has_tables) const {
  std::string text = repairs_text(input);
  if (albedo_clamped > 0)
    text += fmt::format("{} albedo texels were negative or not finite, and were read as 0\n", albedo_clamped);
  std::string times;
  double total = 0.0;
  for (const StageTime& stage : stages) {
    times += fmt::format("{}{} {:.2f} s", times.empty() ? "" : ", ", stage.name, stage.seconds);
    total += stage.seconds;
  }
  text += fmt::format("{}; {:.2f} s in total on {}\n", times, total, device);
  if (has_tables) text += footprint_error_text(error);
  if (fit.lobe_count_total > 0 && (has_tables || fit.nonfinite > 0))
    text += fmt::format(
        "{} lobes: {} were not finite, {} were limited to the largest kappa, {} are empty (they represent no normals), "
        "{} have no direction (their normals cancel out), and {} are too sharp for the data format\n",
        fit.lobe_count_total, fit.nonfinite, fit.kappa_clamped, fit.dead_lobes, fit.undirected_lobes,
        output.unrepresentable);
  if (average.slopes_limited > 0)
    text += fmt::format(
        "{} normals are too close to the horizon to be stored as slopes; their tilt was limited to 87 degrees\n",
        average.slopes_limited);
  const bool has_finer =
      std::any_of(accuracy.begin(), accuracy.end(), [&](const AccuracyRow& row) { return row.level < first_level; });
  if (first_level > 0 && stored_only)
    text += fmt::format("levels finer than {} are never visible, so they are not stored\n", first_level);
  else if (first_level > 0)
    text += fmt::format("levels finer than {} are not stored, because renderers compute them from the normal map{}\n",
                        first_level, has_finer && has_tables ? ", as this table does" : "");
  return has_tables ? text + accuracy_table(accuracy) : text;
}

}  // namespace multum
