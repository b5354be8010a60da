// SPDX-License-Identifier: Apache-2.0
// Reads packed fields, whole or section by section, checks them, and unpacks them to a folder like that of multum
// infer.
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

/// Whether the file begins as packed fields do. False also when it cannot be read. Throws Error(kInput) for what
/// first_bytes() refuses.
bool is_packed_field(const std::string& path);

/// Index and description of a file; chunks are read as they are asked for. Not for two threads at once.
class PackedFieldFile {
 public:
  /// Throws Error(kInput) naming the file and what is wrong: another format, cut short, a damaged index or description.
  explicit PackedFieldFile(const std::string& path);

  const FieldDescription& description() const { return description_; }
  const PackedIndex& index() const { return index_; }
  /// "section 3 (chunk: layer 'diffuse' of object 'walls', block 0)", for messages.
  std::string section_name(std::size_t section) const;
  /// Bytes of a section. Throws Error(kInput) naming it where they are damaged.
  std::vector<std::uint8_t> section(std::size_t section);
  /// The section that has the chunk of a block; nothing where nothing is seen in it. Throws Error(kInput) where it is
  /// missing.
  std::optional<std::size_t> chunk_section(std::size_t layer, std::size_t block) const;
  /// The chunk of these bytes of its section. Throws Error(kInput) naming the section where it is damaged, of another
  /// size than its description says, or exceeds the limits. For any number of threads at once, as all that is const.
  std::unique_ptr<TextureChunk> decode_chunk(std::size_t section, std::span<const std::uint8_t> bytes,
                                             const DecodingLimits& limits) const;
  /// Throws Error(kInput) where a chunk's head is of other sizes than the description says.
  void check_head(std::size_t section, const TextureChunkFormat& format) const;
  /// All of it: null where nothing is seen in the block.
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

/// Radiance of a chunk's sample with all mip levels, the finest first, [texel][3]: to be rounded to halves.
std::vector<float> radiance_levels(const TextureChunk& chunk, std::size_t sample);

/// The texture of a chunk's sample with all mip levels, values as the file of an unpacked texture gives them back.
InferredTexture unpacked_texture(const TextureChunk& chunk, std::size_t sample, const std::string& provenance);

struct UnpackReport {
  std::size_t textures = 0, chunks = 0;
  std::vector<std::string> damaged;  // what is wrong with each chunk that was left out
};

/// Writes textures with all mip levels, and last the manifest, to `folder`, which is made. Textures of damaged chunks
/// are left out: their objects have none there. Throws Error, also where a manifest is there already; Cancelled, and
/// then none is.
UnpackReport unpack_field(const std::string& path, const std::string& folder, int threads, Progress* progress);

struct PackedFinding {
  bool passed = true;
  std::string section, detail;
};

/// Decodes every section. Throws Error(kInput) where not even index and description can be read.
std::vector<PackedFinding> verify_packed_field(const std::string& path);

/// What a person wants to know of it, a line each.
std::string packed_field_text(const std::string& path);

}  // namespace multum
