// SPDX-License-Identifier: Apache-2.0
// Reads and writes the scene of an animation as JSON, for the manifest of inferred textures and the description of a
// packed field.
#pragma once

#include <nlohmann/json.hpp>

#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// Returns the whole manifest except for its version.
nlohmann::json scene_json(const InferredManifest& manifest);

/// Throws nlohmann::json::exception. Throws Error(kInput) if picture sizes are invalid, if there are no samples, or if
/// a sample lacks the index of a parameter or an object's mapping. The caller adds the file's name.
InferredManifest scene_from(const nlohmann::json& json);

}  // namespace multum
