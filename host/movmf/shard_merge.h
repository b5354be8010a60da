// SPDX-License-Identifier: Apache-2.0
// Gathers the shares of a map in the checkpoint of its bake, which then has nothing left to fit.
#pragma once

#include <string>

#include "host/image/plane_store.h"
#include "host/movmf/bake_checkpoint.h"
#include "host/movmf/bake_settings.h"
#include "host/pyramid/feature_planes.h"

namespace multum {

/// Rows of shares 0 to `count` of `output`, whose rows depend on `key`. Throws Error(kEnvironment) that lists every
/// share that is missing or damaged; what was taken stays.
void gather_shards(const std::string& output, int count, const std::string& key, const PlaneStore& normals,
                   const FeaturePlanes& features, const MovmfSettings& settings, BakeCheckpoint& checkpoint);

/// Removes their files.
void remove_shards(const std::string& output, int count);

}  // namespace multum
