// SPDX-License-Identifier: Apache-2.0
// Reports the results, times and clamped values of a bake, as a table or as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/start_memory.h"
#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/image/plane_mosaic.h"
#include "host/formats/opencl/device.h"

namespace multum {

struct StageTime {
  std::string name;  // "read", "fit", "measure", "write"
  double seconds;
};

/// Times and counts of rounding rows and passing them to the writer during the fit.
struct OutputReport {
  double round_seconds = 0.0;
  double write_wait_seconds = 0.0;  // time spent waiting for the thread that compresses and writes
  // The number of lobes on levels 1 and coarser that are too sharp for the encoding, and the share of normals that
  // these lobes represent (host/formats/asset/lobes/movmf_mipmap.h, SharpLobes).
  std::uint64_t unrepresentable = 0;
  double unrepresentable_amplitude = 0.0;
  double unrepresentable_share = 0.0;
};

struct BakeReport {
  std::string source;
  int first_level = 0;       // the finest stored level
  bool stored_only = false;  // true if finer levels are never shown
  std::string shard;         // file of the share if only one share was baked; otherwise empty
  bool unchanged = false;    // true if the output already existed; all other fields are then meaningless
  std::string device;
  std::uint64_t rows_resumed = 0;  // rows of levels that a killed bake had finished
  NormalMapReport input;
  std::int64_t albedo_clamped = 0;           // number of albedo texels with a negative or non-finite value, which is
                                             // read as 0
  std::optional<RoughnessReport> roughness;  // set if the bake has a roughness map
  std::vector<StageTime> stages;
  FitReport fit;          // for lobes
  AverageReport average;  // for moments and harmonics
  OutputReport output;
  std::map<std::string, std::uint64_t> launches;  // number of launches per kernel
  std::map<std::string, double> launch_seconds;   // device seconds per kernel if launches were timed (--runstats)
  TransferCounts transfers;                       // copies between host and device
  std::uint64_t device_bytes_peak = 0;            // largest total of device buffers
  std::map<std::string, int> builds;              // number of programs built or loaded from the cache, by
                                                  // kernels/FILE.cl
  std::vector<AccuracyRow> accuracy;
  std::vector<FootprintError> error;        // pixel errors for each BRDF of `accuracy`
  std::string choice;                       // reasons for the chosen settings, one per line; empty if no settings were
                                            // chosen
  std::shared_ptr<const MapMosaic> mosaic;  // set if BakeJob::keeps_mosaic is true and the whole map was baked
  std::shared_ptr<StartMemory> starts;      // starts of the fitted lobes, set together with `mosaic`
  std::optional<double> picture_error;      // relative L1 error of a picture with the chosen settings, if it was drawn

  /// Returns the plan of the bands and levels, either of the fit or of the averages.
  const std::string& plan() const { return fit.plan.empty() ? average.plan : fit.plan; }
  /// Returns the total time of all stages, except for choosing settings and measuring.
  double bake_seconds() const;
  std::string to_json() const;
  /// Formats a few lines for a terminal, or all tables if `has_tables` is true.
  std::string to_text(bool has_tables) const;
};

}  // namespace multum
