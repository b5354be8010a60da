// SPDX-License-Identifier: Apache-2.0
// Fits every level of a pyramid of lobes on the device, from the coarsest to the finest (Han et al. 2007, section 7),
// once the coarsest level's start is known, and hands rows over as they are done. movmf_bake.h is what bakes call.
#pragma once

#include <vector>

#include "host/asset/lobes/movmf_finest.h"
#include "host/asset/lobes/movmf_mipmap.h"
#include "host/base/progress.h"
#include "host/image/plane_store.h"
#include "host/movmf/bake_checkpoint.h"
#include "host/movmf/bake_plan.h"
#include "host/movmf/bake_settings.h"
#include "host/movmf/fit_report.h"
#include "host/opencl/device.h"
#include "host/pyramid/feature_planes.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// Takes what a bake makes, exact to float: rows of a level in order from its first, coarse levels first, but rows of
/// level 0 between those of level 1.
class MovmfSink {
 public:
  virtual ~MovmfSink() = default;
  virtual void add_level(int level, int first_row, MovmfLevel rows) = 0;
  virtual void add_finest(int first_row, MovmfFinest rows) = 0;
};

/// A part of a baked map that is fitted again, beside the rest as it is.
class RegionInputs {
 public:
  virtual ~RegionInputs() = default;
  /// The texels of a level that are fitted.
  virtual TexelRange range(int level) const = 0;
  /// The level's lobes as they are, by rows [lobe][column].
  virtual RowStore kept(int level) const = 0;
};

struct MovmfFitInputs {
  const PlaneStore* normals;
  FeaturePlanes features;
  bool has_roughness;                    // normals are shortened
  std::vector<MultumVmfLobe> top_start;  // of the coarsest level's texel, one a lobe
  int threads = 1;
  BakeCheckpoint* checkpoint = nullptr;  // null: nothing is kept for another process
  const RegionInputs* region = nullptr;  // null: the whole map
};

/// Begins to build the programs that fit_movmf() launches for such a schedule, those that it launches first first.
void prepare_fit(Device& device, const MipSchedule& schedule, const MovmfSettings& settings, bool has_features);

/// Fits the levels of `schedule` and hands their rows to `sink`. Settings must be valid, features of the map's size.
/// Progress advances by movmf_bake_units().
void fit_movmf(Device& device, const MovmfFitInputs& inputs, const MovmfSettings& settings, const MipSchedule& schedule,
               const BakePlan& plan, MovmfSink& sink, FitReport& report, Progress* progress);

}  // namespace multum
