// SPDX-License-Identifier: Apache-2.0
// Fits one level in bands of rows that slide down the level. Memory therefore does not need to hold the whole level or
// the whole map.
//
// A texel depends on the results of earlier steps at its eight neighbours. Step s of a row therefore needs only step s
// - 1 of the adjacent rows. All steps move down the level, and each is one row behind the previous step:
//
//   step 0          rows  [f, f + B)
//   step 1          rows  [f - 1, f + B - 1)
//   ...
//   last step S-1   rows  [f - S + 1, f + B - S + 1)      done: handed over
//
// Refining (movmf_refine.cl) is a separate step after the EM steps. It reads the lobes of EM and writes to another
// window.
//
// The result for a texel depends on neither B nor f. It is bit for bit the same as if each step were run over the whole
// level. In a map that repeats, the first and last rows depend on each other. Therefore S - 1 rows beyond either border
// are also fitted, but they are not handed over.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/level_rows.h"
#include "host/bakes/movmf/movmf_binning.h"
#include "host/bakes/movmf/movmf_em_step.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// Data that is read from the map once for all coarse levels.
struct CoarseTexels {
  bool is_read = false;
  std::optional<MapWindows> on_device;  // all normals and features, if the device has room for them
  std::map<int, BinnedLevel> binned;    // levels of kBinned
};

/// Finished rows that the windows still hold.
struct FittedRows {
  int first_row, row_count;
  const RowWindow* lobes;     // a window with these rows; refined lobes if the level is refined
  const RowWindow* features;  // [triple][lobe]; null if there are no features
  const MapWindow* normals;   // the normals that the rows cover, on levels that are fitted to all normals; otherwise
                              // null
  MultumMovmfFit fit;         // with the current windows
  const RowWindow* em_lobes;  // lobes of EM, from which finer levels grow; the same as `lobes` if the level is not
                              // refined
};

/// True if --refine changes lobes of the level (kRefinedNormalsMin).
bool is_refined(const LevelSchedule& level, const MovmfSettings& settings);

struct BandPlan {
  int band_rows;      // B, at least 1; if it is the level's height, all rows are fitted at once
  int map_band_rows;  // rows of the map per band, for kChunks, which reads the map in bands
};

/// The fit of one level, or of a part of its rows.
class LevelFit {
 public:
  /// `fitted` is the range of rows to hand over. Other rows are already finished or belong to another process. On a map
  /// that repeats, rows may be outside the borders. `origin` provides the parents, the lobes from which the level
  /// starts, and the texels to fit.
  LevelFit(Device& device, MovmfEmStep& em_step, const LevelSchedule& level, const MovmfSettings& settings,
           const MapInputs& map, CoarseTexels& coarse, RowOrigin& origin, const LevelRows& fitted, const BandPlan& plan,
           Progress* progress);

  /// Calls `finished` with rows in order, beginning with row 0. Throws Cancelled.
  void run(const std::function<void(const FittedRows&)>& finished);

 private:
  using RowRange = LevelRows;
  void make_windows(Device& device, const MovmfSettings& settings, CoarseTexels& coarse, const BandPlan& plan);
  bool refines() const { return steps_ > em_steps_; }
  bool has_features() const { return !map_.features.empty(); }
  // True if the method directly reads the rows of the map that the window's rows cover.
  bool reads_map_rows() const { return level_.method == FitMethod::kTexels || level_.method == FitMethod::kChoice; }
  // True if the map repeats. Rows beyond a border then exist if the steps need them.
  bool repeats() const { return fit_.periodic_y != 0 && fit_.parent_width > 0; }
  int lower_bound() const { return repeats() ? std::min(wanted_.begin, 0) - steps_ : 0; }
  int upper_bound() const { return repeats() ? std::max(wanted_.end, fit_.height) + steps_ : fit_.height; }
  RowRange rows_of_step(int step) const;
  void move_windows(RowRange rows);
  int last_map_row(int row) const;
  RowWindow::Fill fill_alignment_vectors(const RowWindow::Fill& fill_lobes);
  std::vector<int> texels_of_step(int step, RowRange rows) const;
  MultumMovmfFit fit_of_pass(int pass) const;
  void refine(RowRange rows);

  MovmfEmStep& em_step_;
  const LevelSchedule& level_;
  MultumMovmfFit fit_;
  const MapInputs& map_;
  const CoarseTexels& coarse_;
  const bool has_parent_;
  const std::optional<TexelRange> range_;  // nullopt means all texels
  const RowWindow::Fill before_, parent_;
  const int lobe_count_;
  const bool gaussians_;
  const bool whole_;
  const int band_rows_;
  const int em_steps_;
  const int steps_;        // number of steps, including refinement
  const int handed_rows_;  // rows that are handed over at a time
  const RowRange wanted_;  // rows to hand over
  Progress* progress_;
  StepWindows windows_;
  std::optional<MapWindows> windows_of_map_;  // set if the map is not on the device
};

/// The ranges of rows that LevelFit hands over, for all rows of a level that grows from another level. Files store
/// their tiles in the order of these ranges.
std::vector<LevelRows> handed_ranges(const Device& device, const LevelSchedule& level, const MovmfSettings& settings,
                                     const MapInputs& map, const BandPlan& plan);

/// Returns the number of steps of a level. The fit of a row depends on the same number of rows on either side.
int fit_steps(const LevelSchedule& level, const MovmfSettings& settings);

/// Returns the approximate number of bytes in the windows and buffers of LevelFit.
std::uint64_t fit_level_bytes(const LevelSchedule& level, const MovmfSettings& settings, int rgb_plane_count,
                              const BandPlan& plan);

}  // namespace multum
