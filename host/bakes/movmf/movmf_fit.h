// SPDX-License-Identifier: Apache-2.0
// Fits the levels of a pyramid of lobes on the device, from the coarsest to the finest (Han et al. 2007, section 7).
// Skips rows that already exist, and hands over other rows when they are finished. Bakes use this class through
// movmf_bake.h.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "host/bakes/movmf/bake_plan.h"
#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/movmf_binning.h"
#include "host/bakes/movmf/movmf_em_step.h"
#include "host/bakes/movmf/movmf_level_fit.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/processes/background_task.h"
#include "host/foundation/base/progress.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// Starts to build the programs that MovmfFit needs for a schedule, in the order in which they are launched.
void prepare_fit(Device& device, const MipSchedule& schedule, const MovmfSettings& settings, bool has_features);

class MovmfFit {
 public:
  /// Returns the lobes of the coarsest level's texel, or of its texels if there are copies of a map (make_copies()).
  using ChooseStart = std::function<std::vector<MultumVmfLobe>()>;

  /// Settings must be valid, and features must have the map's size. All arguments must outlive the object. Calls
  /// `choose_start` before it fits the coarsest level. Progress advances by movmf_bake_units().
  MovmfFit(Device& device, const MapInputs& map, const MovmfSettings& settings, const MipSchedule& schedule,
           const BakePlan& plan, RowOrigin& rows, ChooseStart choose_start, FitReport& report, Progress* progress);

  /// Fits a level. Call this function for the levels of the schedule in order.
  void fit(const LevelSchedule& level);
  /// Handles a map of a single texel, which has no level 1.
  void fit_single_texel();

 private:
  struct ZeroRows {
    int first_row, row_count;
    std::vector<std::uint8_t> lobe;
  };

  std::size_t lobe_count() const { return static_cast<std::size_t>(settings_.lobe_count); }
  bool has_features() const { return !map_.features.empty(); }
  // Returns the number of feature planes, [triple][lobe].
  std::size_t feature_planes() const { return lobe_count() * map_.features.rgb_planes.size(); }
  LevelReport& report_of(int level) { return report_.levels[static_cast<std::size_t>(level - settings_.first_level)]; }
  bool makes_level_zero(int level) const { return level == 1 && settings_.first_level == 0 && rows_.sink() != nullptr; }
  LevelShape shape_of(const LevelSchedule& level) const;
  void read_coarse_normals(FitMethod method);
  void hand_over_there(const LevelSchedule& level, const LevelShape& shape, int row_count);
  int finest_end(const MultumMovmfFit& fit, int row) const;
  RowStore parentless_start(const LevelSchedule& level);
  void hand_over(const LevelSchedule& level, const FittedRows& rows, bool is_there);
  void advance(const LevelRows& rows, int height);
  ZeroRows fit_level_zero(const FittedRows& rows);
  void hand_over_finest(ZeroRows rows);

  Device& device_;
  const MapInputs& map_;
  const MovmfSettings settings_;
  const MipSchedule& schedule_;
  const BakePlan& plan_;
  RowOrigin& rows_;
  const ChooseStart choose_start_;
  FitReport& report_;
  Progress* progress_;
  MovmfEmStep em_step_;
  Kernel level_zero_kernel_;
  const int map_width_, map_height_;
  CoarseTexels coarse_;
  LevelRows kept_;  // rows of the current level to keep
  double zero_seconds_ = 0.0;
  std::uint64_t zero_launches_ = 0;
  BackgroundTask handing_over_;  // passes the last rows to the sink
};

}  // namespace multum
