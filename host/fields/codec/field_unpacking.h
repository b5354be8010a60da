// SPDX-License-Identifier: Apache-2.0
// Reads packed fields as a whole or section by section, checks them, and unpacks them to a folder in the format of
// `multum infer`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/fields/codec/decoder/packed_index.h"
#include "host/fields/codec/decoder/texture_chunk.h"
#include "host/fields/codec/field_description.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/progress.h"

namespace multum {

/// Returns whether the file begins like a packed field. Returns false if it cannot be read. Throws Error(kInput) for
/// files that first_bytes() rejects.
bool is_packed_field(const std::string& path);

/// The index and description of a file. Chunks are read on request. Two threads must not use one object at once.
class PackedFieldFile {
 public:
  /// Throws Error(kInput), which names the file and its fault. The file can have another format, be truncated, or have
  /// a damaged index or description.
  explicit PackedFieldFile(const std::string& path);

  const std::string& path() const { return path_; }
  const FieldDescription& description() const { return description_; }
  const PackedIndex& index() const { return index_; }
  /// Returns a name for messages: "section 3 (chunk: layer 'diffuse' of object 'walls', block 0)".
  std::string section_name(std::size_t section) const;
  /// Returns the bytes of a section. Throws Error(kInput), which names the section, if they are damaged.
  std::vector<std::uint8_t> section(std::size_t section);
  /// Returns the section with a block's chunk, or nullopt if nothing in the block is visible. Throws Error(kInput) if
  /// the section is missing.
  std::optional<std::size_t> chunk_section(std::size_t layer, std::size_t block) const;
  /// Decodes the chunk from its section's bytes. Throws Error(kInput), which names the section, if the chunk is
  /// damaged, exceeds the limits, or differs in size from its description. Any number of threads may call this and the
  /// other const functions at once.
  std::unique_ptr<TextureChunk> decode_chunk(std::size_t section, std::span<const std::uint8_t> bytes,
                                             const DecodingLimits& limits) const;
  /// Throws Error(kInput) if the sizes in a chunk's head differ from the description.
  void check_head(std::size_t section, const TextureChunkFormat& format) const;
  /// Reads and decodes a chunk. Returns null if nothing in the block is visible.
  std::unique_ptr<TextureChunk> chunk(std::size_t layer, std::size_t block);

 private:
  std::vector<std::uint8_t> bytes_at(std::uint64_t offset, std::uint64_t count);
  void read_index();

  std::string path_;
  RegularFileStream stream_;
  std::uint64_t size_ = 0;
  PackedIndex index_;
  FieldDescription description_;
};

/// Returns the radiance of a chunk's sample with all mip levels, the finest first, [texel][3]. The values are not yet
/// rounded to 16-bit floats.
std::vector<float> radiance_levels(const TextureChunk& chunk, std::size_t sample);

/// Returns the texture of a chunk's sample with all mip levels. The values are the same as those read from an unpacked
/// file.
InferredTexture unpacked_texture(const TextureChunk& chunk, std::size_t sample, const std::string& provenance);

struct UnpackReport {
  std::size_t textures = 0, chunks = 0;
  std::vector<std::string> damaged;  // the faults of all chunks that were left out
};

/// Creates `folder` and writes the textures with all mip levels, and then the manifest. The textures of damaged chunks
/// are left out, so the objects have no texture at these samples. Throws Error, for example if a manifest already
/// exists. If cancelled, throws Cancelled and writes no manifest.
UnpackReport unpack_field(const std::string& path, const std::string& folder, int threads, Progress* progress);

struct PackedFinding {
  bool passed = true;
  std::string section, detail;
};

/// Decodes every section. Throws Error(kInput) if the index or the description cannot be read.
std::vector<PackedFinding> verify_packed_field(const std::string& path);

/// Returns the JSON text of `multum info --json`: the parameters with their numbers of samples, the size of the frames,
/// the objects, the layers and the sections.
std::string packed_field_facts(const PackedFieldFile& file);

/// Returns human-readable facts about the file, one per line.
std::string packed_field_text(const std::string& path);

}  // namespace multum
