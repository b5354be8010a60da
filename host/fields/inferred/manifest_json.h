// SPDX-License-Identifier: Apache-2.0
// Reads, writes and checks what the manifest of inferred textures and the description of a packed field share.
#pragma once

#include <nlohmann/json.hpp>

#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// Scene file, its hash, the set of texture coordinates, the pictures' size, the parameters' names.
nlohmann::json scene_keys_json(const InferredManifest& manifest);

/// Reads them. Throws nlohmann::json::exception, and Error(kInput) without the file's name for a size that there is
/// not.
void read_scene_keys(const nlohmann::json& json, InferredManifest& manifest);

/// Throws Error(kInput), without the file's name, unless there are samples, and each has an index for each parameter.
void check_samples(const InferredManifest& manifest);

/// Throws Error(kInput), without the file's name, unless each sample has one of the object's mappings.
void check_mappings(const InferredManifest& manifest, const InferredObject& object);

}  // namespace multum
