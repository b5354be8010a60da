// SPDX-License-Identifier: Apache-2.0
// Describes a packed field to who plays it: all of the manifest that drawing needs, and which chunk has which texture.
// docs/reference/packed_fields.md, "Packed fields", has the bytes.
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
  std::vector<int> unseen;  // samples at which the object has no texture of the layer, rising

  bool is_seen(std::size_t sample) const;
  /// The block that a point of the grid lies in.
  std::size_t block_at(const std::vector<int>& at) const;
};

struct FieldDescription {
  InferredManifest field;           // its objects' layers have no textures
  SampleGrid grid;                  // of the field's samples
  std::vector<PackedLayer> layers;  // numbered as sections number them, object by object
};

/// The section's bytes. Numbers are rounded to single precision: what a GL draws with.
std::vector<std::uint8_t> encode_description(const FieldDescription& description);

/// Throws Error(kInput), without the file's name, which the caller knows.
FieldDescription decode_description(std::span<const std::uint8_t> bytes);

}  // namespace multum
