// SPDX-License-Identifier: Apache-2.0
// Bakes maps to one lobe per texel. Such a lobe stores only the mean of the normals, so plain averages
// (host/bakes/pyramid/average_pass.h), which take one pass over the map, give the same lobe as EM.
#pragma once

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// True if plain averages give the same result as these settings. False if only a part of a map is baked, because the
/// lobes around the part already exist.
bool averages_suffice(const RowOrigin& rows, const MovmfSettings& settings);

/// Does the same as bake_movmf(), for settings for which averages_suffice() returns true. Progress advances by
/// movmf_bake_units().
void average_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, MovmfSink& sink,
                   FitReport& report, Progress* progress);

}  // namespace multum
