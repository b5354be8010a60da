// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum bake`, of manifests, of the maps of scenes and of jobs of type bake.
#pragma once

#include "host/foundation/parameters/parameter.h"

namespace multum {

/// Groups of bake_parameters(), as help texts head them.
inline constexpr const char kSourceGroup[] = "Reading the map";
inline constexpr const char kMaterialGroup[] = "Material maps";
inline constexpr const char kStorageGroup[] = "Storage";
inline constexpr const char kFitGroup[] = "Fitting lobes";
inline constexpr const char kTargetGroup[] = "Settings chosen by a target";
inline constexpr const char kRunGroup[] = "Running the bake";

const ParameterTable& bake_parameters();

/// Jobs of type scene: the maps' own parameters are in scene.toml, which has those of bake_parameters() that are
/// kInScene.
const ParameterTable& scene_parameters();

}  // namespace multum
