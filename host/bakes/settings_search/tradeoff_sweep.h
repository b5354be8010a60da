// SPDX-License-Identifier: Apache-2.0
// Measures the cost of accuracy in time, on this machine, for one map: bakes it with every kind of setting, measures
// the error against the reference, and draws it. Bakes are complete bakes of the whole map; pictures and frame times
// come from multum-view, a child process.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/settings_search/setting_choice.h"
#include "host/foundation/base/run_times.h"

namespace multum {

enum class SweepLength { kQuick, kDefault, kFull };

struct TradeoffJob {
  BakeJob bake;     // input, roughness and settings for reading them; swept settings are ignored
  TargetBrdf brdf;  // kRoughness if there is a roughness map
  SweepLength length = SweepLength::kDefault;
  bool measures_all_brdfs = false;  // TradeoffRow::errors cover all BRDFs, not only `brdf`
  std::string viewer;               // multum-view; empty: draw nothing
  std::string context = "auto";     // option of multum-view
  std::string decode = "child";     // option of multum-view
  std::string output;               // the page, which the caller writes; hidden files are written next to it
  int width = 320, height = 240;    // of pictures
  int samples = 64;                 // per pixel of the reference
  std::optional<double> error;      // choose settings for this error or time; at most one is set
  std::optional<double> bake_seconds;
  // Budgets. Rows state whether they meet all given budgets, and only rows that do can be chosen.
  std::optional<std::uint64_t> bytes_max;  // limit for textures on the GPU
  std::optional<double> frame_ms_max;      // needs a viewer
  std::optional<double> bake_seconds_max;

  bool has_roughness() const { return !bake.roughness.empty(); }
  bool has_budget() const { return bytes_max || frame_ms_max || bake_seconds_max; }
};

/// One bake, drawn in one way.
struct TradeoffRow {
  std::string group;                     // varied setting: "lobes", "storage", ...
  std::string options;                   // options of `multum bake`
  std::string view;                      // options of `multum-view`; if empty, only the BRDF is given
  ReachedError reached;                  // pixel error with its interval
  std::vector<FootprintError> errors;    // errors of each measured BRDF, with the shading of this row
  double rendered = -1.0;                // picture error, against a reference with the same filter; < 0 if not drawn
  RunTime bake;                          // time of fitting or averaging, and of writing; reading is shared by all rows
  double frame_ms = -1.0;                // elapsed time; < 0 if not drawn
  double frame_work_ms = -1.0;           // processor time if software draws, else GPU time; < 0 if not drawn
  std::uint64_t normals_file_bytes = 0;  // size on disk of the normal map, if it provides the finest levels
  std::uint64_t file_bytes = 0;          // with these
  std::uint64_t normals_bytes = 0;       // size on the GPU of the normal map, if it provides the finest levels
  std::uint64_t gpu_bytes = 0;           // with these
  std::string picture;                   // PNG bytes; empty if not drawn
  bool is_measured = true;               // false for another BRDF, or for a formula that only the renderer has
  bool has_error = false;                // true if `reached` is known (if not is_measured, for the row's own BRDF)
  bool fits = true;                      // TradeoffJob's budgets
  std::vector<std::string> warnings;     // warnings of the bake, without the map's name
  bool on_time_front = false, on_frame_front = false, on_size_front = false;  // not beaten (mark_fronts())
  // For a row on a front: another row on a front that is indistinguishable in error and in every cost.
  std::optional<std::size_t> same_as;

  bool on_front() const { return on_time_front || on_frame_front || on_size_front; }
};

/// Noise of bake and frame times: relative 95 % half widths from repeated runs of the default settings.
struct TimeNoise {
  double bake = 0.0, frame = 0.0;
};
/// Student's 95 % half width of one of several repeated times, at least two, divided by their mean.
double relative_half_width(const std::vector<double>& times);

/// Marks rows on the fronts of error against the work of a bake, the work of a frame, and memory, and marks rows that
/// are indistinguishable. A row is not on a front if another row is better in cost or error by more than the intervals,
/// and not worse in either by more than the intervals. Elapsed times are ignored: on a busy machine they reflect
/// other load.
void mark_fronts(std::vector<TradeoffRow>& rows, const TimeNoise& noise);

struct TradeoffResult {
  std::vector<TradeoffRow> rows;
  std::string reference;              // PNG bytes of the reference picture; empty if there is none
  std::string device;                 // that baked
  std::string renderer;               // that drew
  int width = 0, height = 0;          // size of the map
  std::optional<std::size_t> chosen;  // the row for the job's error, time or budgets
  TimeNoise noise;
  double seconds = 0.0;

  /// Number of rows whose error for the job's BRDF is measured; only these are ranked and chosen from.
  std::size_t setting_count() const;
};

/// Throws Error, Cancelled; leaves no files next to TradeoffJob::output. Progress: one unit per row.
TradeoffResult run_tradeoff(const TradeoffJob& job, Device& device, Progress* progress);

}  // namespace multum
