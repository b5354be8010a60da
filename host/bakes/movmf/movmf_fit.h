// SPDX-License-Identifier: Apache-2.0
// Fits every level of a pyramid of lobes on the device, from the coarsest to the finest (Han et al. 2007, section 7),
// once the coarsest level's start is known, and hands rows over as they are done. movmf_bake.h is what bakes call.
#pragma once

#include <vector>

#include "host/bakes/movmf/bake_plan.h"
#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/movmf_inputs.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"
#include "kernels/shared/vmf_lobe.h"

namespace multum {

/// Begins to build the programs that fit_movmf() launches for such a schedule, those that it launches first first.
void prepare_fit(Device& device, const MipSchedule& schedule, const MovmfSettings& settings, bool has_features);

/// Settings are valid, features are of the map's size. `top_start`: the coarsest level's texel, one a lobe. Progress
/// advances by movmf_bake_units().
void fit_movmf(Device& device, const MovmfBakeInputs& inputs, const std::vector<MultumVmfLobe>& top_start,
               const MovmfSettings& settings, const MipSchedule& schedule, const BakePlan& plan, MovmfSink& sink,
               FitReport& report, Progress* progress);

}  // namespace multum
