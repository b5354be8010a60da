// SPDX-License-Identifier: Apache-2.0
// Divides an inference into independent pieces, which are combined into shares of the work. Also makes the manifest of
// all textures.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include "host/fields/inference/pipeline/animation_probe.h"
#include "host/fields/inference/pipeline/inference_pipeline.h"
#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// Finds an affine map of texture coordinates for each object and block. Warns about objects that no picture shows.
ObjectMappings find_object_mappings(const ParameterizedScene& field);

/// The textures of one layer of an object in one block. Each texture except the first starts from the previous one. No
/// texture starts from another piece's texture.
struct InferencePiece {
  int block = 0;
  std::size_t object = 0, layer = 0;
  auto operator<=>(const InferencePiece&) const = default;
};

/// Returns the pieces of visible objects, block by block. The layers of an object follow one another, because they use
/// the same filter matrices.
std::vector<InferencePiece> inference_pieces(const ParameterizedScene& field, const ObjectMappings& mappings);

/// Divides the pieces into `count` shares of successive pieces. All shares take about the same time. If there are more
/// shares than pieces, some shares are empty.
std::vector<std::vector<InferencePiece>> divide_pieces(const ParameterizedScene& field, const ObjectMappings& mappings,
                                                       int count);

/// Returns the manifest of all textures. `geometry_hash` is as in AnimationProbe.
InferredManifest manifest_of(const ParameterizedScene& field, const AnimationInferSettings& settings,
                             const ObjectMappings& mappings, const std::string& geometry_hash,
                             const std::vector<TextureResult>& textures);

}  // namespace multum
