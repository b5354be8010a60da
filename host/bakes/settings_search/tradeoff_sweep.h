// SPDX-License-Identifier: Apache-2.0
// Measures the trade-off between accuracy and time for one map on this machine. Bakes the whole map with every kind of
// setting, measures the error against the reference, and draws the map. Pictures and frame times come from multum-view,
// which runs as a child process.
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
  bool measures_all_brdfs = false;  // true if TradeoffRow::errors cover all BRDFs, not only `brdf`
  std::string viewer;               // multum-view; if empty, nothing is drawn
  std::string context = "auto";     // option of multum-view
  std::string decode = "child";     // option of multum-view
  std::string output;               // the page, which the caller writes; hidden files are written next to it
  int width = 320, height = 240;    // size of pictures
  int samples = 64;                 // per pixel of the reference
  std::optional<double> error;      // error or time for which settings are chosen; at most one is set
  std::optional<double> bake_seconds;
  // The budgets. Each row states whether it meets all given budgets. Only rows that meet them can be chosen.
  std::optional<std::uint64_t> bytes_max;  // limit for textures on the GPU
  std::optional<double> frame_ms_max;      // needs a viewer
  std::optional<double> bake_seconds_max;

  bool has_roughness() const { return !bake.roughness.empty(); }
  bool has_budget() const { return bytes_max || frame_ms_max || bake_seconds_max; }
};

/// A bake together with one way of drawing it.
struct TradeoffRow {
  std::string group;                     // the setting that is varied, such as "lobes" or "storage"
  std::string options;                   // options of `multum bake`
  std::string view;                      // options of `multum-view`; if empty, only the BRDF is given
  ReachedError reached;                  // pixel error with its interval
  std::vector<FootprintError> errors;    // errors of each measured BRDF, with the shading of this row
  double rendered = -1.0;                // error of the picture relative to a reference drawn with the same filter; < 0
                                         // if not drawn
  RunTime bake;                          // time to fit or average, and to write; the map is read once for all rows
  double frame_ms = -1.0;                // elapsed time; < 0 if not drawn
  double frame_work_ms = -1.0;           // processor time if drawn by software, otherwise GPU time; < 0 if not drawn
  std::uint64_t normals_file_bytes = 0;  // size on disk of the normal map, if it provides the finest levels
  std::uint64_t file_bytes = 0;          // size on disk, including the normal map
  std::uint64_t normals_bytes = 0;       // size on the GPU of the normal map, if it provides the finest levels
  std::uint64_t gpu_bytes = 0;           // size on the GPU, including the normal map
  std::string picture;                   // PNG bytes; empty if not drawn
  bool is_measured = true;               // false if the row uses another BRDF or a formula that only the renderer has
  bool has_error = false;                // true if `reached` is known; if not is_measured, `reached` is for the row's
                                         // own BRDF
  bool fits = true;                      // true if the row meets the budgets of TradeoffJob
  std::vector<std::string> warnings;     // warnings of the bake, without the map's name
  bool on_time_front = false, on_frame_front = false, on_size_front = false;  // true if no other row is better
                                                                              // (mark_fronts())
  // For a row on a front, names another row on a front that is indistinguishable in error and in every cost.
  std::optional<std::size_t> same_as;

  bool on_front() const { return on_time_front || on_frame_front || on_size_front; }
};

/// The noise of bake times and frame times. It is the relative half width of a 95 % interval, from repeated runs with
/// the default settings.
struct TimeNoise {
  double bake = 0.0, frame = 0.0;
};
/// Returns the half width of Student's 95 % interval for a single time, divided by the mean of the repeated times.
/// There must be at least two times.
double relative_half_width(const std::vector<double>& times);

/// Marks rows on the fronts of error against the work of a bake, the work of a frame, and memory, and marks rows that
/// are indistinguishable. A row is not on a front if another row beats it. The other row must be better in cost or
/// error by more than the intervals, and must not be worse in either by more than the intervals. Elapsed times are
/// ignored, because on a busy machine they depend on other programs.
void mark_fronts(std::vector<TradeoffRow>& rows, const TimeNoise& noise);

struct TradeoffResult {
  std::vector<TradeoffRow> rows;
  std::string reference;              // PNG bytes of the reference picture; empty if there is none
  std::string device;                 // device that baked
  std::string renderer;               // renderer that drew
  int width = 0, height = 0;          // size of the map
  std::optional<std::size_t> chosen;  // the row for the job's error, time or budgets
  TimeNoise noise;
  double seconds = 0.0;

  /// Number of rows whose error for the job's BRDF is measured. Only these rows are ranked and can be chosen.
  std::size_t setting_count() const;
};

/// Throws Error and Cancelled. Leaves no files next to TradeoffJob::output. Progress: one unit per row.
TradeoffResult run_tradeoff(const TradeoffJob& job, Device& device, Progress* progress);

}  // namespace multum
