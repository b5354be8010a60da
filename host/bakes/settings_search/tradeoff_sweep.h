// SPDX-License-Identifier: Apache-2.0
// Measures what accuracy costs in time, on this machine, for one map: bakes it with every kind of setting, measures the
// error against the reference, and draws it. Bakes are whole and real; pictures and frame times are multum-view's, a
// child process.
#pragma once

#include <string>
#include <vector>

#include "host/bakes/settings_search/setting_choice.h"
#include "host/foundation/base/run_times.h"

namespace multum {

enum class SweepLength { kQuick, kDefault, kFull };

struct TradeoffJob {
  BakeJob bake;     // its input, roughness and how to read them; settings that are swept do not count
  TargetBrdf brdf;  // kRoughness with a roughness map
  SweepLength length = SweepLength::kDefault;
  bool measures_all_brdfs = false;  // TradeoffRow::errors are of every BRDF that bakes measure, not of `brdf` alone
  std::string viewer;               // multum-view; empty: nothing is drawn
  std::string context = "auto";     // of multum-view
  std::string decode = "child";     // of multum-view, too
  std::string output;               // the page, which others write; baked files and pictures lie beside it, hidden
  int width = 320, height = 240;    // of pictures
  int samples = 64;                 // a pixel of the reference
  std::optional<double> error;      // what to pick settings for: one of both, or none
  std::optional<double> bake_seconds;
  // Budgets: rows say whether they keep to all that are set, and only those may be chosen.
  std::optional<std::uint64_t> bytes_max;  // of textures on the GPU
  std::optional<double> frame_ms_max;      // needs a viewer
  std::optional<double> bake_seconds_max;

  bool has_roughness() const { return !bake.roughness.empty(); }
  bool has_budget() const { return bytes_max || frame_ms_max || bake_seconds_max; }
};

/// One bake, drawn in one way.
struct TradeoffRow {
  std::string group;                     // "lobes", "storage", ...: what is varied
  std::string options;                   // of `multum bake`
  std::string view;                      // of `multum-view`; empty: none beside the BRDF
  ReachedError reached;                  // of pixels, with its interval
  std::vector<FootprintError> errors;    // the same of each BRDF that was measured, as it is drawn here
  double rendered = -1.0;                // of the picture, against one of the same filter's reference; < 0: not drawn
  RunTime bake;                          // of fitting or averaging, and writing; reading is the same for all
  double frame_ms = -1.0;                // elapsed; < 0: not drawn
  double frame_work_ms = -1.0;           // of processors where software draws, else by the GPU's clock; < 0: not drawn
  std::uint64_t normals_file_bytes = 0;  // on disk, of the normal map that has the levels finer than the file's first
  std::uint64_t file_bytes = 0;          // with these
  std::uint64_t normals_bytes = 0;    // on the GPU, of the normal map that has the levels finer than the file's first
  std::uint64_t gpu_bytes = 0;        // with these
  std::string picture;                // PNG bytes; empty: not drawn
  bool is_measured = true;            // false: another BRDF, or a formula that only the renderer has
  bool has_error = false;             // is `reached` known? Of a row that is not measured: the error of its own BRDF
  bool fits = true;                   // TradeoffJob's budgets
  std::vector<std::string> warnings;  // of the bake, without the map's name
  bool on_time_front = false, on_frame_front = false, on_size_front = false;  // nothing is better (mark_fronts())
  // On a front: the row on a front that it cannot be told apart from, neither by its error nor by what it costs.
  std::optional<std::size_t> same_as;

  bool on_front() const { return on_time_front || on_frame_front || on_size_front; }
};

/// Of the work that bakes and frames take. Parts of themselves: 95 % half widths, from the default settings' repeated
/// runs.
struct TimeNoise {
  double bake = 0.0, frame = 0.0;
};
/// Of some repeated times: Student's 95 % half width of one of them, over their mean; at least two.
double relative_half_width(const std::vector<double>& times);

/// Marks rows on the fronts of error against the work of a bake, the work of a frame, and memory, and which of them are
/// the same. A row is off a front where another is cheaper or nearer by more than their intervals, and in neither worse
/// by more than these. Elapsed times do not count: on a busy machine they say what else it does.
void mark_fronts(std::vector<TradeoffRow>& rows, const TimeNoise& noise);

struct TradeoffResult {
  std::vector<TradeoffRow> rows;
  std::string reference;              // PNG bytes of the picture that all are compared with; empty: none
  std::string device;                 // that baked
  std::string renderer;               // that drew
  int width = 0, height = 0;          // of the map
  std::optional<std::size_t> chosen;  // the row for the job's error, time or budgets
  TimeNoise noise;
  double seconds = 0.0;

  /// Rows whose error for the job's BRDF is measured: those that are ranked and chosen from.
  std::size_t setting_count() const;
};

/// Throws Error, Cancelled; nothing is left beside TradeoffJob::output. Progress: a unit a row.
TradeoffResult run_tradeoff(const TradeoffJob& job, Device& device, Progress* progress);

}  // namespace multum
