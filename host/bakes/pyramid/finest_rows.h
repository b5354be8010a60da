// SPDX-License-Identifier: Apache-2.0
// Makes rows of level 0 from the source of a bake, before they are rounded and assigned to lobes.
#pragma once

#include "host/bakes/pyramid/feature_planes.h"
#include "host/formats/asset/lobes/movmf_finest.h"
#include "host/formats/image/plane_store.h"

namespace multum {

/// Makes rows [first_row, first_row + row_count) of the map. All texels belong to lobe 0.
MovmfFinest finest_rows(const PlaneStore& normals, const FeaturePlanes& features, Representation representation,
                        int first_row, int row_count, int threads);

}  // namespace multum
