// SPDX-License-Identifier: Apache-2.0
// What a bake did, took and clamped: for people (a table) and for programs (JSON).
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/bake/accuracy.h"
#include "host/image/material_maps.h"
#include "host/image/normal_map.h"
#include "host/opencl/device.h"

namespace multum {

struct StageTime {
  std::string name;  // "read", "fit", "measure", "write"
  double seconds;
};

struct LevelReport {
  int level, width, height;
  double seconds;
  std::uint64_t launches;
};

struct BakeReport {
  std::string source;
  int first_level = 0;       // the finest that is stored
  bool stored_only = false;  // finer ones are never seen
  bool unchanged = false;    // the output was there already: nothing was done, and nothing else here says anything
  std::string device;
  std::uint64_t rows_resumed = 0;  // rows of levels that a killed bake had done
  NormalMapReport input;
  std::int64_t albedo_clamped = 0;           // texels of the albedo with a negative or non-finite value, read as 0
  std::optional<RoughnessReport> roughness;  // of a bake with a roughness map
  std::vector<StageTime> stages;
  double start_seconds = 0.0;     // of "fit": choosing where the coarsest level starts
  double condense_seconds = 0.0;  // of "fit": condensing the normals of coarse texels
  std::uint64_t condense_launches = 0;
  double round_seconds = 0.0;       // of "fit": rounding rows to what is stored
  double write_wait_seconds = 0.0;  // of "fit": waiting for the thread that compresses and writes
  std::string plan;                 // BakePlan::to_text()
  std::uint64_t start_launches = 0;
  int starts_rehearsed = 0;                       // candidates whose pyramid was tried on a small likeness of the map
  std::vector<LevelReport> levels;                // finest first
  std::map<std::string, std::uint64_t> launches;  // by kernel
  std::map<std::string, double> launch_seconds;   // on the device, by kernel, where launches were timed (--runstats)
  TransferCounts transfers;                       // copies between host and device
  std::uint64_t device_bytes_peak = 0;            // of buffers on the device, of all that it has done
  std::map<std::string, int> builds;              // programs built or loaded from the cache, by kernels/FILE.cl
  // Rare numerical events, over all texels and lobes of all levels.
  std::uint64_t lobe_count_total = 0;
  std::uint64_t nonfinite = 0;      // must be 0
  std::uint64_t kappa_clamped = 0;  // sharper than MovmfSettings::kappa_cap: EM may have fitted them as if less sharp
  std::uint64_t dead_lobes = 0;     // amplitude below 1e-6; below 1e-7 (DEAD_SHARE) EM keeps its last direction
  std::uint64_t undirected_lobes = 0;  // |r| below 1e-3: opposite normals in equal shares
  std::uint64_t slopes_limited = 0;    // normals nearer to the horizon than slopes of moments go (kSlopeZMin)
  // Lobes of levels coarser than 0 whose spread the storage does not keep, and the share of those levels' normals that
  // they stand for (host/asset/movmf_mipmap.h, SharpLobes).
  std::uint64_t beyond_storage = 0;
  double beyond_storage_amplitude = 0.0;
  double beyond_storage_share = 0.0;
  std::vector<AccuracyRow> accuracy;
  std::vector<AccuracySummary> error;  // one for each BRDF of `accuracy`
  std::string choice;                  // why these settings, where they were chosen; a line each

  /// Of all stages but choosing and measuring.
  double bake_seconds() const;
  std::string to_json() const;
  /// Some lines for a terminal.
  std::string to_text() const;
};

}  // namespace multum
