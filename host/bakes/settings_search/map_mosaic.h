// SPDX-License-Identifier: Apache-2.0
// Makes the mosaic of a map together with its features (host/formats/image/plane_mosaic.h).
#pragma once

#include "host/bakes/bake/bake_source.h"
#include "host/formats/image/plane_mosaic.h"

namespace multum {

/// Makes the mosaic in memory. Blocks of feature maps are taken from the same places as blocks of the normals.
BakeSource make_mosaic(const BakeSource& source, const MosaicSettings& settings);

}  // namespace multum
