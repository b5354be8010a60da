// SPDX-License-Identifier: Apache-2.0
// Bakes maps to one lobe per texel: the mean of the normals is all that the lobe stores, so that EM has nothing to
// share out, and plain averages (host/bakes/pyramid/average_pass.h) give the same lobe in one pass over the map.
#pragma once

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Do plain averages give what these settings ask for? Not of a part of a map, which lies beside lobes that are there.
bool averages_suffice(const RowOrigin& rows, const MovmfSettings& settings);

/// As bake_movmf(), of settings that averages_suffice() takes. Progress advances by movmf_bake_units().
void average_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, MovmfSink& sink,
                   FitReport& report, Progress* progress);

}  // namespace multum
