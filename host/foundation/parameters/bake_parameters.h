// SPDX-License-Identifier: Apache-2.0
// Lists the parameters of `multum bake`, of manifests, of maps in scenes, and of jobs of type bake.
#pragma once

#include <vector>

#include "host/foundation/parameters/parameter.h"

namespace multum {

/// Headings of the groups of bake_parameters() in help texts.
inline constexpr const char kSourceGroup[] = "Reading the map";
inline constexpr const char kMaterialGroup[] = "Material maps";
inline constexpr const char kStorageGroup[] = "Storage";
inline constexpr const char kFitGroup[] = "Fitting lobes";
inline constexpr const char kTargetGroup[] = "Settings chosen by a target";
inline constexpr const char kRunGroup[] = "Running the bake";

const ParameterTable& bake_parameters();

/// Returns the rows of kSourceGroup for another command that reads maps. They are not part of a settings hash.
std::vector<Parameter> reading_parameters(unsigned surfaces);

/// The parameters of jobs of type scene. The parameters of the maps are in scene.toml. They are the rows of
/// bake_parameters() with kInScene.
const ParameterTable& scene_parameters();

}  // namespace multum
