// SPDX-License-Identifier: Apache-2.0
// Fits every level of a pyramid on the device, from the coarsest to the finest (Han et al. 2007, section 7), once the
// coarsest level's start is known. movmf_bake.h is what bakes call.
#pragma once

#include <vector>

#include "host/asset/movmf_mipmap.h"
#include "host/bake/bake_report.h"
#include "host/bake/bake_settings.h"
#include "host/base/progress.h"
#include "host/image/normal_map.h"
#include "host/opencl/device.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

struct MovmfFitPlan {
  std::vector<MultumVmfLobe> top_start;  // of the coarsest level's texel, one a lobe
  bool weighted = false;                 // use the weighted kernels whatever the size
};

/// Settings are valid, `albedo` is null or of the map's size. Progress advances by movmf_bake_units().
MovmfMipmap fit_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                      const MovmfFitPlan& plan, BakeReport& report, Progress* progress);

}  // namespace multum
