// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of von Mises-Fisher mixtures (Han et al. 2007, section 7), or of mixtures of
// planar Gaussians (Tan et al. 2005; MovmfSettings::representation): every level is
// fitted to all normals that its texels cover, from the coarsest level to the finest, each texel started from its
// parent's lobes and held to its done neighbours' by the alignment prior, so that hardware filtering mixes lobes of one
// kind. One lobe a texel is its mean normal: averaged, not fitted (host/bakes/movmf/movmf_average.h).
#pragma once

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/movmf_inputs.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// validate() and what the map's size sets limits to. Throws Error(kInput) for a map that is too large, Error(kUsage).
void validate(const MovmfSettings& settings, int map_width, int map_height);

/// Hands rows to `sink` as they are done, exact to float, not yet rounded to what the file stores (quantize_movmf).
/// Counts and times go to `report`. Throws Error(kUsage) for settings out of range and for too little memory,
/// Error(kEnvironment) when the disk or the device refuses, Cancelled.
void bake_movmf(Device& device, const MovmfBakeInputs& inputs, const MovmfSettings& settings, MovmfSink& sink,
                FitReport& report, Progress* progress);

/// The same as a whole, of planes or of maps in memory. Of levels finer than settings.first_level there are sizes
/// alone.
MovmfMipmap bake_movmf(Device& device, const MovmfBakeInputs& inputs, const MovmfSettings& settings, FitReport& report,
                       Progress* progress);
/// `albedo` may be null.
MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       FitReport& report, Progress* progress);

}  // namespace multum
