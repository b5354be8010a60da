// SPDX-License-Identifier: Apache-2.0
// Checks the indices of a glTF file. Each index must refer to an existing element of its array.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace multum {

/// Checks every index that glTF 2.0 defines. Also checks the indices of extensions that multum reads, or that it keeps
/// when it moves the object that contains them. Throws Error(kInput), which names the file, as in
/// "meshes/0/primitives/0/indices is 7, expected a number below 3, the length of accessors". Skips extras, other
/// extensions, and files of glTF 1.0, which has names instead of indices.
void check_gltf_indices(const nlohmann::json& json, const std::string& path);
void check_gltf_indices(const nlohmann::ordered_json& json, const std::string& path);

}  // namespace multum
