// SPDX-License-Identifier: Apache-2.0
// Bakes a normal map into a mip pyramid of von Mises-Fisher mixtures (Han et al. 2007, section 7): every level is
// fitted to all normals that its texels cover, from the coarsest level to the finest, each texel started from its
// parent's lobes and held to its done neighbours' by the alignment prior, so that hardware filtering mixes lobes of one
// kind.
#pragma once

#include "host/asset/movmf_mipmap.h"
#include "host/bake/bake_report.h"
#include "host/bake/bake_settings.h"
#include "host/base/progress.h"
#include "host/image/normal_map.h"
#include "host/opencl/device.h"

namespace multum {

/// validate() and what the map's size sets limits to. Throws Error(kInput) for a map that is too large, Error(kUsage).
void validate(const MovmfSettings& settings, int map_width, int map_height);

/// `albedo` may be null. Counts and times go to `report`. The result's values are exact to float, not yet rounded to
/// what the file stores (quantize_movmf). Throws Error(kUsage) for settings out of range, Error(kEnvironment) when the
/// device cannot hold the map, Cancelled. Of levels finer than settings.first_level there are sizes alone.
MovmfMipmap bake_movmf(Device& device, const NormalMap& map, const ColourMap* albedo, const MovmfSettings& settings,
                       BakeReport& report, Progress* progress);

/// Units of progress that bake_movmf() advances by.
std::uint64_t movmf_bake_units(int width, int height, int first_level = 0);

}  // namespace multum
