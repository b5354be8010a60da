// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of von Mises-Fisher mixtures (Han et al. 2007, section 7), or of mixtures of
// planar Gaussians (Tan et al. 2005; MovmfSettings::representation). Levels are fitted from the coarsest to the finest,
// each to all normals that its texels cover. Each texel starts from its parent's lobes, and the alignment prior ties it
// to fitted neighbours, so that hardware filtering mixes similar lobes. If there is one lobe per texel, the lobe is the
// mean normal, which is computed by averaging (host/bakes/movmf/movmf_average.h).
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

/// Makes the same checks as validate(), and also checks limits that depend on the map's size. Throws Error(kUsage), and
/// Error(kInput) for a map that is too large.
void validate(const MovmfSettings& settings, int map_width, int map_height);

/// Number of progress units of a bake of lobes.
inline std::uint64_t movmf_bake_units(int width, int height, int first_level = 0) {
  return static_cast<std::uint64_t>(mip_level_count(width, height) - first_level) * static_cast<std::uint64_t>(width) *
         static_cast<std::uint64_t>(height);
}

/// Passes finished rows to the sink of `rows` as floats, before they are rounded for storage (quantize_movmf). `starts`
/// is shared by the bakes of this map. If it is null, this bake searches for its own start. Counts and times go to
/// `report`. Throws Error(kUsage) for settings out of range and for too little memory, Error(kEnvironment) for errors
/// of the disk or the device, and Cancelled.
void bake_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, RowOrigin& rows,
                StartMemory* starts, FitReport& report, Progress* progress);

/// Bakes planes in memory into a whole mipmap. Levels finer than settings.first_level have only sizes.
MovmfMipmap bake_movmf(Device& device, const MapInputs& map, const MovmfSettings& settings, FitReport& report,
                       Progress* progress, StartMemory* starts = nullptr);
/// Bakes maps in memory into a whole mipmap. `albedo` may be null.
MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       FitReport& report, Progress* progress);

}  // namespace multum
