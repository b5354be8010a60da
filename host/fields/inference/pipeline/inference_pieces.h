// SPDX-License-Identifier: Apache-2.0
// Divides an inference into pieces that can be done by themselves, which shares of the work are made of, and makes the
// manifest of all textures.
#pragma once

#include <compare>
#include <string>
#include <vector>

#include "host/fields/inference/pipeline/animation_probe.h"
#include "host/fields/inference/pipeline/inference_pipeline.h"
#include "host/fields/inferred/inferred_texture.h"

namespace multum {

/// An affine map of texture coordinates for each object and block. Warns of objects that are seen in no picture.
ObjectMappings find_object_mappings(const ParameterizedScene& field);

/// The textures of one layer of an object in one block: each starts from the one before, and none from those of another
/// piece.
struct InferencePiece {
  int block = 0;
  std::size_t object = 0, layer = 0;
  auto operator<=>(const InferencePiece&) const = default;
};

/// Of objects that are seen, block by block, the layers of one object together: neighbours share filter matrices.
std::vector<InferencePiece> inference_pieces(const ParameterizedScene& field, const ObjectMappings& mappings);

/// Divides them into `count` shares of neighbours that take about as long; some are empty where there are more shares
/// than pieces.
std::vector<std::vector<InferencePiece>> divide_pieces(const ParameterizedScene& field, const ObjectMappings& mappings,
                                                       int count);

/// The manifest of all textures. `geometry_hash` as of AnimationProbe.
InferredManifest manifest_of(const ParameterizedScene& field, const AnimationInferSettings& settings,
                             const ObjectMappings& mappings, const std::string& geometry_hash,
                             const std::vector<TextureResult>& textures);

}  // namespace multum
