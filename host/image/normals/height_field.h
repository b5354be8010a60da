// SPDX-License-Identifier: Apache-2.0
// Height fields: the normal of the surface (x, y, height) by central differences.
#pragma once

#include <cstdint>
#include <string>

#include "host/image/normals/normal_map.h"
#include "host/image/raw_image.h"

namespace multum {

/// The image's colour channels (equal up to noise) are averaged. Integers are 0..1. Non-finite heights, which
/// `nonfinite_count` texels hold, are repaired by settings.fix_nan (kBox3: mean of the finite 3 x 3 neighbours, else 0;
/// kBlack: 0) before slopes are taken. Fills the report's counts and encoding (with the rms slope: a wrong height_scale
/// shows there). Throws and cancels as decode_normals() does.
NormalMapRows normals_from_heights(const std::string& path, const RawImage& image, std::int64_t nonfinite_count,
                                   const NormalMapSettings& settings, const SpillPolicy& spill, int threads,
                                   Progress* progress);

}  // namespace multum
