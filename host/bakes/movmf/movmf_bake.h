// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of von Mises-Fisher mixtures (Han et al. 2007, section 7), or of mixtures of
// planar Gaussians (Tan et al. 2005; MovmfSettings::representation): every level is
// fitted to all normals that its texels cover, from the coarsest level to the finest, each texel started from its
// parent's lobes and held to its done neighbours' by the alignment prior, so that hardware filtering mixes lobes of one
// kind. One lobe a texel is its mean normal: averaged, not fitted (host/bakes/movmf/movmf_average.h).
#pragma once

#include "host/bakes/movmf/bake_settings.h"
#include "host/bakes/movmf/fit_report.h"
#include "host/bakes/movmf/row_origin.h"
#include "host/bakes/movmf/start_memory.h"
#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/image/normals/normal_map.h"
#include "host/formats/opencl/device.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// validate() and what the map's size sets limits to. Throws Error(kInput) for a map that is too large, Error(kUsage).
void validate(const MovmfSettings& settings, int map_width, int map_height);

/// Units of progress that a bake of lobes advances by.
inline std::uint64_t movmf_bake_units(int width, int height, int first_level = 0) {
  return static_cast<std::uint64_t>(mip_level_count(width, height) - first_level) * static_cast<std::uint64_t>(width) *
         static_cast<std::uint64_t>(height);
}

/// Hands rows to the sink of `rows` as they are done, exact to float, not yet rounded to what the file stores
/// (quantize_movmf). `starts` is of bakes of this map; null: this one searches its start. Counts and times go to
/// `report`. Throws Error(kUsage) for settings out of range and for too little memory,
/// Error(kEnvironment) when the disk or the device refuses, Cancelled.
void bake_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, RowOrigin& rows,
                StartMemory* starts, FitReport& report, Progress* progress);

/// The same as a whole, of planes or of maps in memory. Of levels finer than settings.first_level there are sizes
/// alone.
MovmfMipmap bake_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, FitReport& report,
                       Progress* progress, StartMemory* starts = nullptr);
/// `albedo` may be null.
MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       FitReport& report, Progress* progress);

}  // namespace multum
