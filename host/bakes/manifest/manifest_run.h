// SPDX-License-Identifier: Apache-2.0
// Brings one map of a manifest up to date. Bakes the map if its file is missing or stale, and otherwise leaves the file
// unchanged. A check also verifies and measures the file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "host/bakes/bake/bake_report.h"
#include "host/bakes/manifest/bake_manifest.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// The state in which a map was found. docs/reference/manifests.md describes each state.
enum class MapState {
  kUnchanged,  // in place; a check also found that the file is undamaged and that no error exceeds the stated or
               // allowed error
  kBaked,      // baked in this run; a check reports one of the states below instead
  kMissing,    // occurs only in checks, like the next two states
  kStale,
  kDamaged,
  kWorse,   // in place or just baked, but with an error above the stated error or error_max
  kFailed,  // the map could not be read or baked, so nothing is known about it
};
constexpr int kMapStateCount = 7;
const char* map_state_name(MapState state);
inline bool is_in_place(MapState state) { return state == MapState::kUnchanged || state == MapState::kBaked; }

struct MapResult {
  std::string name;
  MapState state = MapState::kUnchanged;
  std::string why;                   // the reason, for every state except kUnchanged and kBaked
  std::optional<BakeReport> report;  // set if the file was written in this run
  // The largest relative L1 error. `error` was measured in this run, `stated` is from the header of the existing file,
  // and `allowed` is from the manifest.
  std::optional<double> error, stated, allowed;
  double seconds = 0.0;
  std::uint64_t bytes = 0;                // size of the file; 0 if it does not exist
  ErrorCode failure = ErrorCode::kInput;  // the error of a map that is kFailed
};

struct ManifestRunSettings {
  bool check = false;    // verify and measure existing files; missing and stale files are findings
  bool dry_run = false;  // bake nothing, but check that needed bakes can read their inputs
};

/// Throws Error if the map cannot be read or baked, and Cancelled.
MapResult run_manifest_map(const ManifestMap& map, const ManifestRunSettings& settings, Device& device,
                           Progress* progress);

/// Returns the result for a map for which run_manifest_map() has thrown an exception.
MapResult failed_map(const ManifestMap& map, const Error& error);

}  // namespace multum
