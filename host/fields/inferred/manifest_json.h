// SPDX-License-Identifier: Apache-2.0
// Reads and writes the scene of an animation as JSON, for the manifest of inferred textures and the description of a
// packed field.
#pragma once

#include <nlohmann/json.hpp>

#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// Returns the whole manifest except for its version.
nlohmann::json scene_json(const InferredManifest& manifest);

/// Throws nlohmann::json::exception. Throws Error(kInput) without the file's name for invalid picture sizes, for no
/// samples, and for a sample without an index for each parameter or without one of an object's mappings.
InferredManifest scene_from(const nlohmann::json& json);

}  // namespace multum
