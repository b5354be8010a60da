// SPDX-License-Identifier: Apache-2.0
#include "host/bake/manifest_run.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>

#include "host/bake/baked_check.h"
#include "host/bake/output_state.h"
#include "host/base/content_hash.h"

namespace multum {
namespace {

void add_reason(MapResult& result, const std::string& reason) {
  result.why += (result.why.empty() ? "" : "; ") + reason;
}

// A file whose header is as it should be: is the rest of it?
void check_in_place(const ManifestMap& map, const OutputState& found, Device& device, Progress* progress,
                    MapResult& result) {
  const BakedCheck check = check_baked_file(map.job, device, progress);
  if (!check.damage.empty()) {
    result.state = MapState::kDamaged;
    result.why = check.damage;
    return;
  }
  result.error = worst_error(check.measured);
  result.why = worse_than_stated(check.measured, found.stated);
  if (!result.why.empty()) result.state = MapState::kWorse;
}

// What a check calls a file that is not as this bake would make it.
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

void bake_map(const ManifestMap& map, Device& device, Progress* progress, MapResult& result) {
  BakeJob job = map.job;
  job.force = true;  // that it must be baked is known
  if (!map.target) {
    result.report = bake_file(job, device, progress);
  } else {
    const ChosenBake chosen = bake_to_target(job, *map.target, device, progress);
    if (chosen.written) result.report = chosen.report;
    if (!chosen.met) {
      result.state = MapState::kWorse;
      add_reason(result, fmt::format("no settings reach {}: the best, {}, are {} off{}", target_text(*map.target),
                                     chosen.options, error_text(chosen.reached.error, chosen.reached.confidence),
                                     chosen.written ? "" : ", not written"));
    }
  }
  if (result.report) result.error = worst_error(result.report->accuracy);
}

// A file that is left as it is without a look is taken at its word.
void hold_to_allowed(MapResult& result) {
  const std::optional<double> error =
      result.error || result.state != MapState::kUnchanged ? result.error : result.stated;
  if (!result.allowed || !error || *error <= *result.allowed) return;
  if (is_in_place(result.state)) result.state = MapState::kWorse;
  add_reason(result,
             fmt::format("is {:.4g} % off, error_max allows {:.4g} %", 100.0 * *error, 100.0 * *result.allowed));
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
  result.stated = worst_error(found.stated);
  const bool is_current = found.finding == OutputFinding::kInPlace && !map.job.force;
  if (settings.check) {
    note_finding(found, result);
    if (is_current) check_in_place(map, found, device, progress, result);
  }
  // A file that is worse than it should be would be no better for being baked again from the same source.
  const bool must_be_baked = !is_current || result.state == MapState::kDamaged;
  if (must_be_baked && settings.dry_run) {
    hash_file(map.job.input);  // a source that is not there is another matter than a file that is missing
  } else if (must_be_baked) {
    bake_map(map, device, progress, result);
    if (!settings.check && result.state != MapState::kWorse) result.state = MapState::kBaked;
    else if (settings.check && result.report) add_reason(result, "baked now");
  }
  hold_to_allowed(result);
  std::error_code none;
  const auto bytes = std::filesystem::file_size(map.job.output, none);
  result.bytes = none ? 0 : bytes;
  return result;
}

MapResult failed_map(const ManifestMap& map, const Error& error) {
  MapResult result;
  result.name = map.name;
  result.state = MapState::kFailed;
  result.why = error.what();
  result.allowed = map.error_max;
  // A setting that does not fit its map is the manifest's, and that is a file, not the command line.
  result.failure = error.code() == ErrorCode::kUsage ? ErrorCode::kInput : error.code();
  return result;
}

}  // namespace multum
