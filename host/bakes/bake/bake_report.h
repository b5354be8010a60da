// SPDX-License-Identifier: Apache-2.0
// Collects what a bake did, how long it took and what it clamped, and prints it as a table or as JSON.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/pyramid/average_pass.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/opencl/device.h"

namespace multum {

struct StageTime {
  std::string name;  // "read", "fit", "measure", "write"
  double seconds;
};

/// Times and events of rounding rows to what is stored and handing them to the writer, while they are fitted.
struct OutputReport {
  double round_seconds = 0.0;
  double write_wait_seconds = 0.0;  // waiting for the thread that compresses and writes
  // Lobes of levels coarser than 0 whose spread the storage does not keep, and the share of those levels' normals that
  // they stand for (host/formats/asset/lobes/movmf_mipmap.h, SharpLobes).
  std::uint64_t unrepresentable = 0;
  double unrepresentable_amplitude = 0.0;
  double unrepresentable_share = 0.0;
};

struct BakeReport {
  std::string source;
  int first_level = 0;       // the finest that is stored
  bool stored_only = false;  // finer ones are never seen
  std::string shard;         // the file of the only share that was baked; empty: all of it was
  bool unchanged = false;    // the output was there already: nothing was done, and nothing else here says anything
  std::string device;
  std::uint64_t rows_resumed = 0;  // rows of levels that a killed bake had done
  NormalMapReport input;
  std::int64_t albedo_clamped = 0;           // texels of the albedo with a negative or non-finite value, read as 0
  std::optional<RoughnessReport> roughness;  // of a bake with a roughness map
  std::vector<StageTime> stages;
  FitReport fit;          // of lobes
  AverageReport average;  // of moments and harmonics
  OutputReport output;
  std::map<std::string, std::uint64_t> launches;  // by kernel
  std::map<std::string, double> launch_seconds;   // on the device, by kernel, where launches were timed (--runstats)
  TransferCounts transfers;                       // copies between host and device
  std::uint64_t device_bytes_peak = 0;            // of buffers on the device
  std::map<std::string, int> builds;              // programs built or loaded from the cache, by kernels/FILE.cl
  std::vector<AccuracyRow> accuracy;
  std::vector<FootprintError> error;    // of pixels: one for each BRDF of `accuracy`
  std::string choice;                   // why these settings, where they were chosen; a line each
  std::optional<double> picture_error;  // of a picture of what was chosen, where one was drawn: relative L1

  /// Plan of bands and levels: the fit's, or that of the averages.
  const std::string& plan() const { return fit.plan.empty() ? average.plan : fit.plan; }
  /// Sum of all stages but choosing and measuring.
  double bake_seconds() const;
  std::string to_json() const;
  /// Some lines for a terminal.
  std::string to_text() const;
};

}  // namespace multum
