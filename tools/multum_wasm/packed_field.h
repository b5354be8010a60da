// SPDX-License-Identifier: Apache-2.0
// The decoder of packed fields (docs/reference/packed_fields.md) as functions that WebAssembly can export: they take
// and return only numbers and addresses of the module's memory. tools/wasm_decoder compiles them; packed_field.mjs is
// the JavaScript side. No function throws: if memory runs out the module traps, which JavaScript sees as an exception.
#pragma once

#include <cstddef>
#include <cstdint>

#ifdef __wasm__
#define MULTUM_EXPORT(name) extern "C" __attribute__((export_name(#name)))
#else
#define MULTUM_EXPORT(name) extern "C"
#endif

struct MultumPackedField;
struct MultumTextureChunk;

/// Returns `size` bytes for the caller to fill, or null if there is too little memory. They must not be released while
/// a
/// field is open on them.
MULTUM_EXPORT(multum_allocate) void* multum_allocate(std::size_t size);
MULTUM_EXPORT(multum_release) void multum_release(void* memory);

/// `bytes`: a whole file. Returns null if they are not a packed field, or if its index is damaged.
MULTUM_EXPORT(multum_open) MultumPackedField* multum_open(const std::uint8_t* bytes, std::size_t size);
MULTUM_EXPORT(multum_close) void multum_close(MultumPackedField* field);
/// Returns why the last open or decode returned null: UTF-8, ended by a 0.
MULTUM_EXPORT(multum_problem) const char* multum_problem();

/// The stored description's offset in the file and its size in bytes. Both are 0 if it is damaged or missing.
MULTUM_EXPORT(multum_description_offset) std::size_t multum_description_offset(const MultumPackedField* field);
MULTUM_EXPORT(multum_description_length) std::size_t multum_description_length(const MultumPackedField* field);

/// Chunks are numbered from 0 in the index's order; `chunk` must be below the count.
MULTUM_EXPORT(multum_chunk_count) std::size_t multum_chunk_count(const MultumPackedField* field);
MULTUM_EXPORT(multum_chunk_layer) std::uint32_t multum_chunk_layer(const MultumPackedField* field, std::size_t chunk);
MULTUM_EXPORT(multum_chunk_block) std::uint32_t multum_chunk_block(const MultumPackedField* field, std::size_t chunk);

/// Decodes the coefficients of all images of a chunk; null if the chunk is damaged. The field may be closed afterwards.
MULTUM_EXPORT(multum_decode) MultumTextureChunk* multum_decode(const MultumPackedField* field, std::size_t chunk);
/// Decodes a chunk from its section only, for callers that fetch ranges of a file. The caller has compared the
/// checksum.
MULTUM_EXPORT(multum_decode_section)
MultumTextureChunk* multum_decode_section(const std::uint8_t* bytes, std::size_t size);
MULTUM_EXPORT(multum_chunk_close) void multum_chunk_close(MultumTextureChunk* chunk);
/// Width and height of each texture, in texels.
MULTUM_EXPORT(multum_width) std::size_t multum_width(const MultumTextureChunk* chunk);
MULTUM_EXPORT(multum_height) std::size_t multum_height(const MultumTextureChunk* chunk);
/// Number of textures in the chunk.
MULTUM_EXPORT(multum_sample_count) std::size_t multum_sample_count(const MultumTextureChunk* chunk);

/// Writes the texture of a sample below the count to `out`, [height][width][3], red, green, blue: gamma-coded floats,
/// 255 for a radiance of 1.
MULTUM_EXPORT(multum_texture) void multum_texture(const MultumTextureChunk* chunk, std::size_t sample, float* out);
/// Writes the texture as radiance: halves, rounded to nearest; the largest is 65504.
MULTUM_EXPORT(multum_radiance_halves)
void multum_radiance_halves(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out);

/// Number of texels in all mip levels of a texture.
MULTUM_EXPORT(multum_level_texels) std::size_t multum_level_texels(const MultumTextureChunk* chunk);
/// Writes the radiance of all mip levels, finest first, as halves, like `multum unpack`; [texels][3].
MULTUM_EXPORT(multum_radiance_levels)
void multum_radiance_levels(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out);
