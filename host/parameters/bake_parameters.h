// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum bake`, of manifests, of the maps of scenes and of jobs of type bake.
#pragma once

#include "host/parameters/parameter.h"

namespace multum {

/// Groups of bake_parameters(), as help texts head them.
inline constexpr const char kSourceGroup[] = "How the map is read";
inline constexpr const char kMaterialGroup[] = "Maps beside it";
inline constexpr const char kStorageGroup[] = "What is stored";
inline constexpr const char kFitGroup[] = "How lobes are fitted";
inline constexpr const char kTargetGroup[] = "Settings chosen by a target";
inline constexpr const char kRunGroup[] = "How the bake runs";

const ParameterTable& bake_parameters();

/// Jobs of type scene: the maps' own parameters are in scene.toml, which has those of bake_parameters() that are
/// kInScene.
const ParameterTable& scene_parameters();

}  // namespace multum
