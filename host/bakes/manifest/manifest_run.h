// SPDX-License-Identifier: Apache-2.0
// Brings one map of a manifest into place: bakes it where its file is missing or stale, leaves it alone where it is as
// it should be; in a check, examines it thoroughly, too.
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

/// State that a map was found in; docs/reference/manifests.md has a line for each.
enum class MapState {
  kUnchanged,  // in place; in a check: whole and no worse than stated and allowed, too
  kBaked,      // baked in this run; in a check the states below say why it had to be
  kMissing,    // checks only, as the next two
  kStale,
  kDamaged,
  kWorse,   // in place or just baked, but worse than it states, or than error_max allows
  kFailed,  // could not be read or baked: nothing is known of it
};
constexpr int kMapStateCount = 7;
const char* map_state_name(MapState state);
inline bool is_in_place(MapState state) { return state == MapState::kUnchanged || state == MapState::kBaked; }

struct MapResult {
  std::string name;
  MapState state = MapState::kUnchanged;
  std::string why;                   // of every state but kUnchanged, kBaked
  std::optional<BakeReport> report;  // set: the file was written in this run
  // The largest relative L1 error: measured in this run; by the header of the file that was found; as the manifest
  // allows.
  std::optional<double> error, stated, allowed;
  double seconds = 0.0;
  std::uint64_t bytes = 0;                // of the file, 0 without one
  ErrorCode failure = ErrorCode::kInput;  // of kFailed
};

struct ManifestRunSettings {
  bool check = false;    // verify and measure what is in place; missing and stale files are findings
  bool dry_run = false;  // checks only: bake nothing, but read what would be baked
};

/// Throws Error when the map cannot be read or baked, Cancelled.
MapResult run_manifest_map(const ManifestMap& map, const ManifestRunSettings& settings, Device& device,
                           Progress* progress);

/// Result of a map for which run_manifest_map() threw.
MapResult failed_map(const ManifestMap& map, const Error& error);

}  // namespace multum
