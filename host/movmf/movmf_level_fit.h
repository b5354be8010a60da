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
// What a texel becomes depends on neither B nor f, and equals what the steps give over the whole level at once, bit for
// bit. In a map that repeats the first and last rows depend on one another: S - 1 rows beyond either border are fitted
// as well, and not handed over.
#pragma once

#include <functional>
#include <vector>

#include "host/movmf/fit_report.h"
#include "host/movmf/movmf_binning.h"
#include "host/movmf/movmf_em_step.h"

namespace multum {

/// Texels [x0, x1) x [y0, y1) of a level.
struct TexelRange {
  int x0, y0, x1, y1;
};

/// Inputs of the fit of a level.
struct LevelInputs {
  const PlaneStore* normals = nullptr;
  MapWindows* on_device = nullptr;          // the same, whole; null: windows of it are made
  std::vector<const PlaneStore*> features;  // rgb_planes
  const BinnedLevel* binned = nullptr;      // kBinned
  const RowStore* parent = nullptr;         // lobes of the next coarser level, by rows [lobe][column]; null: none
  // Where there is no parent: the lobes that each texel starts from, by rows as above.
  const RowStore* start = nullptr;
  int first_row = 0;  // rows above are done already and are not handed over
  // Set: only these texels are fitted, from the lobes that the level has in `kept`, beside its other texels as they
  // are.
  const TexelRange* range = nullptr;
  const RowStore* kept = nullptr;
};

/// Some finished rows, while the windows still hold them.
struct FittedRows {
  int first_row, row_count;
  const RowWindow* lobes;     // of these rows among others
  const RowWindow* features;  // [triple][lobe]; null: none
  const MapWindow* normals;   // what they cover, of levels that are fitted to all normals; null otherwise
  MultumMovmfFit fit;         // as the windows are now
};

struct BandPlan {
  int band_rows;      // B, at least 1; the level's height: all of it at once
  int map_band_rows;  // of the map, where a method passes over it band by band: kChunks
};

/// Calls `finished` with rows in order from 0. Throws Cancelled.
void fit_level(Device& device, MovmfEmStep& em_step, const LevelSchedule& level, const MovmfSettings& settings,
               const LevelInputs& inputs, const BandPlan& plan, const std::function<void(const FittedRows&)>& finished,
               Progress* progress);

/// Bytes of the windows and buffers of fit_level(), about.
std::uint64_t fit_level_bytes(const LevelSchedule& level, const MovmfSettings& settings, int rgb_plane_count,
                              const BandPlan& plan);

}  // namespace multum
