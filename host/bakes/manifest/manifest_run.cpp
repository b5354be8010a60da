// SPDX-License-Identifier: Apache-2.0
#include "host/bakes/manifest/manifest_run.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "host/bakes/bake/bake_file.h"
#include "host/bakes/bake/bake_source.h"
#include "host/bakes/bake/baked_check.h"
#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/bake/output_state.h"
#include "host/foundation/base/files/output_paths.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

void add_reason(MapResult& result, const std::string& reason) {
  result.why += (result.why.empty() ? "" : "; ") + reason;
}

// Checks the texels of a file whose header is as expected.
void check_in_place(const ManifestMap& map, const OutputState& found, Device& device, Progress* progress,
                    MapResult& result) {
  const BakedCheck check = check_baked_file(map.job, device, progress);
  if (!check.damage.empty()) {
    result.state = MapState::kDamaged;
    result.why = check.damage;
    return;
  }
  result.error = worst_error(check.measured.footprint_errors);
  result.why = worse_than_stated(check.measured, found.stated);
  if (!result.why.empty()) result.state = MapState::kWorse;
}

// Sets the state of a file that differs from the result of this bake.
void note_finding(const OutputState& found, MapResult& result) {
  switch (found.finding) {
    case OutputFinding::kInPlace: return;
    case OutputFinding::kMissing:
      result.state = MapState::kMissing;
      result.why = "there is no such file";
      return;
    case OutputFinding::kUnreadable: result.state = MapState::kDamaged; break;
    case OutputFinding::kStale: result.state = MapState::kStale; break;
  }
  result.why = found.why;
}

// Returns 0 if the file does not exist.
std::uint64_t file_bytes(const std::string& path) {
  std::error_code none;
  const auto bytes = fs::file_size(path, none);
  return none ? 0 : bytes;
}

void bake_map(const ManifestMap& map, Device& device, Progress* progress, MapResult& result) {
  BakeJob job = map.job;
  make_folder_of(job.output);
  job.force = true;  // the file is already known to need a bake
  if (!map.target) {
    result.report = bake_file(job, nullptr, device, progress);
  } else {
    const ChosenBake chosen = bake_to_target(job, *map.target, device, progress);
    if (chosen.written) result.report = chosen.report;
    if (!chosen.met) {
      result.state = MapState::kWorse;
      add_reason(result, fmt::format("no settings reach {}; the best settings, {}, have an error of {}{}",
                                     target_text(*map.target), chosen.options,
                                     error_text(chosen.reached.error, chosen.reached.confidence),
                                     chosen.written ? "" : ", not written"));
    }
  }
  if (result.report) result.error = worst_error(result.report->error);
}

// Runs all steps of a bake that come before the fit, and throws the same errors. If the bake would create the output
// folder, checks the nearest existing parent folder instead.
void check_can_be_baked(const ManifestMap& map, Progress* progress) {
  BakeJob job = map.job;
  fs::path folder = fs::absolute(fs::path(job.output)).parent_path();
  while (!fs::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  job.output = (folder / fs::path(job.output).filename()).string();
  if (map.target) check_target(*map.target, job);
  check_job(job);
  const BakeSource source = read_bake_source(job, MapReadings::kFew, progress);
  ndf_bake(job.representation).check_map(job, source.map.normals.width(), source.map.normals.height());
}

// If the map cannot be baked, reporting only "missing" would be misleading.
[[noreturn]] void rethrow_with_finding(const Error& error, const MapResult& result) {
  if (result.why.empty()) throw error;
  throw Error(error.code(), fmt::format("{}, and cannot be baked: {}", result.why, error.what()));
}

// For a file that is neither baked nor checked, compares the error stated in its header.
void hold_to_allowed(MapResult& result) {
  const std::optional<double> error =
      result.error || result.state != MapState::kUnchanged ? result.error : result.stated;
  if (!result.allowed || !error || *error <= *result.allowed) return;
  if (is_in_place(result.state)) result.state = MapState::kWorse;
  add_reason(result, fmt::format("has an error of {:.4g} %, but error_max allows {:.4g} %", 100.0 * *error,
                                 100.0 * *result.allowed));
}

}  // namespace

const char* map_state_name(MapState state) {
  static constexpr std::array<const char*, kMapStateCount> kNames = {"unchanged", "baked", "missing", "stale",
                                                                     "damaged",   "worse", "failed"};
  return kNames[static_cast<std::size_t>(state)];
}

MapResult run_manifest_map(const ManifestMap& map, const ManifestRunSettings& settings, Device& device,
                           Progress* progress) {
  MapResult result;
  result.name = map.name;
  result.allowed = map.error_max;
  BakeJob job = map.job;
  if (map.target) job.chosen_for = target_key(map.job, *map.target);
  const OutputState found = find_output_state(job, all_settings_json(job));
  result.stated = worst_error(found.stated.footprint_errors);
  const bool is_current = found.finding == OutputFinding::kInPlace && !map.job.force;
  if (settings.check) {
    note_finding(found, result);
    if (is_current) check_in_place(map, found, device, progress, result);
  }
  // A file that is worse than allowed is not baked again, because a new bake from the same source would have the same
  // error.
  const bool must_be_baked = !is_current || result.state == MapState::kDamaged;
  try {
    if (must_be_baked && settings.dry_run) check_can_be_baked(map, progress);
    else if (must_be_baked) bake_map(map, device, progress, result);
  } catch (const Error& error) {
    rethrow_with_finding(error, result);
  }
  if (must_be_baked && !settings.dry_run) {
    if (!settings.check && result.state != MapState::kWorse) result.state = MapState::kBaked;
    else if (settings.check && result.report) add_reason(result, "baked now");
  }
  hold_to_allowed(result);
  result.bytes = file_bytes(map.job.output);
  return result;
}

MapResult failed_map(const ManifestMap& map, const Error& error) {
  MapResult result;
  result.name = map.name;
  result.state = MapState::kFailed;
  result.why = error.what();
  result.allowed = map.error_max;
  result.bytes = file_bytes(map.job.output);
  // A setting that does not suit its map is an error in the manifest, not in the command line.
  result.failure = error.code() == ErrorCode::kUsage ? ErrorCode::kInput : error.code();
  return result;
}

}  // namespace multum
