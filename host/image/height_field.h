// SPDX-License-Identifier: Apache-2.0
// Height fields: the normal of the surface (x, y, height) by central differences.
#pragma once

#include <string>

#include "host/image/image_io.h"
#include "host/image/normal_map.h"

namespace multum {

/// Consumes `image`; its colour channels (equal up to noise) are averaged. Integers are 0..1. Non-finite heights are
/// repaired by settings.fix_nan (kBox3: mean of the finite 3 x 3 neighbours, else 0; kBlack: 0) before slopes are
/// taken. Fills the report's counts and encoding (with the rms slope: a wrong height_scale shows there). Throws
/// Error(kInput) as decode_normals does.
NormalMap normals_from_heights(const std::string& path, RawImage image, const NormalMapSettings& settings, int threads,
                               Progress* progress);

}  // namespace multum
