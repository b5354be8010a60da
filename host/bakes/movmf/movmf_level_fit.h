// SPDX-License-Identifier: Apache-2.0
// Fits one level in bands of rows that slide down the level, so that neither the level nor the map need fit in memory.
//
// A texel depends on its eight neighbours as the steps before left them, so that step s of a row needs step s - 1 of
// the rows beside it and no more. The steps follow one another down the level, each a row behind the one before:
//
//   step 0          rows  [f, f + B)
//   step 1          rows  [f - 1, f + B - 1)
//   ...
//   last step S-1   rows  [f - S + 1, f + B - S + 1)      done: handed over
//
// Refining (movmf_refine.cl) is a step of its own behind those of EM: it reads what EM left, and writes elsewhere.
//
// What a texel becomes depends on neither B nor f, and equals what the steps give over the whole level at once, bit for
// bit. In a map that repeats the first and last rows depend on one another: S - 1 rows beyond either border are fitted
// as well, and not handed over.
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

/// What is read of the map once for all coarse levels.
struct CoarseTexels {
  bool is_read = false;
  std::optional<MapWindows> on_device;  // normals and features, whole, where the device has room for them
  std::map<int, BinnedLevel> binned;    // levels of kBinned
};

/// Some finished rows, while the windows still hold them.
struct FittedRows {
  int first_row, row_count;
  const RowWindow* lobes;     // of these rows among others, refined where they are
  const RowWindow* features;  // [triple][lobe]; null: none
  const MapWindow* normals;   // what they cover, of levels that are fitted to all normals; null otherwise
  MultumMovmfFit fit;         // as the windows are now
  const RowWindow* em_lobes;  // what EM left, which finer levels grow from: `lobes` where they are not refined
};

/// Whether --refine changes lobes of the level (kRefinedNormalsMin).
bool is_refined(const LevelSchedule& level, const MovmfSettings& settings);

struct BandPlan {
  int band_rows;      // B, at least 1; the level's height: all of it at once
  int map_band_rows;  // of the map, where a method passes over it band by band: kChunks
};

/// The fit of one level, or of a part of its rows.
class LevelFit {
 public:
  /// `fitted`: rows that are handed over: the others are done already, or somebody else's. Of a map that repeats they
  /// may lie beyond its borders. `origin` has parents, what the level starts from, and which of its texels are fitted.
  LevelFit(Device& device, MovmfEmStep& em_step, const LevelSchedule& level, const MovmfSettings& settings,
           const MapInputs& map, CoarseTexels& coarse, const RowOrigin& origin, const LevelRows& fitted,
           const BandPlan& plan, Progress* progress);

  /// Calls `finished` with rows in order from 0. Throws Cancelled.
  void run(const std::function<void(const FittedRows&)>& finished);

 private:
  using RowRange = LevelRows;
  void make_windows(Device& device, const MovmfSettings& settings, CoarseTexels& coarse, const BandPlan& plan);
  bool refines() const { return steps_ > em_steps_; }
  bool has_features() const { return !map_.features.empty(); }
  // The map's rows that the window's rows cover, and no more.
  bool reads_map_rows() const { return level_.method == FitMethod::kTexels || level_.method == FitMethod::kChoice; }
  // Rows beyond a border are there when the map repeats, as many as the steps reach.
  bool repeats() const { return fit_.periodic_y != 0 && fit_.parent_width > 0; }
  int lower_bound() const { return repeats() ? std::min(wanted_.begin, 0) - steps_ : 0; }
  int upper_bound() const { return repeats() ? std::max(wanted_.end, fit_.height) + steps_ : fit_.height; }
  RowRange rows_of_step(int step) const;
  void move_windows(RowRange rows);
  int last_map_row(int row) const;
  RowWindow::Fill fill_alignment_vectors(const RowWindow::Fill& fill_lobes);
  std::vector<int> texels_of_step(int step, RowRange rows) const;
  void run_step(int step, RowRange rows);
  void refine(RowRange rows);

  MovmfEmStep& em_step_;
  const LevelSchedule& level_;
  MultumMovmfFit fit_;
  const MapInputs& map_;
  const CoarseTexels& coarse_;
  const bool has_parent_;
  const std::optional<TexelRange> range_;  // else all texels
  const RowWindow::Fill before_, parent_;
  const int lobe_count_;
  const bool gaussians_;
  const bool whole_;
  const int band_rows_;
  const int em_steps_;
  const int steps_;        // with the one that refines
  const int handed_rows_;  // at a time
  const RowRange wanted_;  // rows that are handed over
  Progress* progress_;
  StepWindows windows_;
  std::optional<MapWindows> windows_of_map_;  // where the map is not on the device
};

/// The rows that LevelFit hands over at a time, of all rows of a level that grows from another: files have their tiles
/// in that order.
std::vector<LevelRows> handed_ranges(const Device& device, const LevelSchedule& level, const MovmfSettings& settings,
                                     const MapInputs& map, const BandPlan& plan);

/// Steps of a level: what a row's fit depends on reaches as many rows to either side.
int fit_steps(const LevelSchedule& level, const MovmfSettings& settings);

/// Bytes of the windows and buffers of LevelFit, about.
std::uint64_t fit_level_bytes(const LevelSchedule& level, const MovmfSettings& settings, int rgb_plane_count,
                              const BandPlan& plan);

}  // namespace multum
