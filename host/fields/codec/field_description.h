// SPDX-License-Identifier: Apache-2.0
// Describes a packed field for players: the parts of the manifest that drawing needs, and the chunk of each texture.
// The byte format is in docs/reference/packed_fields.md, "Packed fields".
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/fields/codec/field_blocks.h"

namespace multum {

struct PackedLayer {
  std::size_t object = 0;  // index into the field's objects
  std::string name;
  std::vector<FieldBlock> blocks;
  std::vector<int> unseen;  // samples without a texture of the layer for this object, in ascending order

  bool is_seen(std::size_t sample) const;
  /// Returns the block that contains a point of the grid.
  std::size_t block_at(const std::vector<int>& at) const;
};

struct FieldDescription {
  InferredManifest field;           // the objects' layers have no textures
  SampleGrid grid;                  // grid of the field's samples
  std::vector<PackedLayer> layers;  // object by object, numbered as in the sections
};

/// Returns the section's bytes. Numbers are rounded to single precision, which OpenGL uses for drawing.
std::vector<std::uint8_t> encode_description(const FieldDescription& description);

/// Throws Error(kInput). The caller adds the file's name.
FieldDescription decode_description(std::span<const std::uint8_t> bytes);

}  // namespace multum
