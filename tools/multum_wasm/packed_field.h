// SPDX-License-Identifier: Apache-2.0
// Declares the decoder of packed fields (docs/reference/packed_fields.md) as functions that WebAssembly can export. All
// arguments and results are numbers or addresses in the module's memory. tools/wasm_decoder compiles the functions, and
// packed_field.mjs calls them from JavaScript. No function throws. If memory runs out, the module traps, and JavaScript
// receives an exception.
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

/// Returns `size` bytes for the caller to fill, or null if there is too little memory. Do not release the bytes while a
/// field that was opened from them is in use.
MULTUM_EXPORT(multum_allocate) void* multum_allocate(std::size_t size);
MULTUM_EXPORT(multum_release) void multum_release(void* memory);

/// `bytes` holds a whole file. Returns null if it is not a packed field, or if its index is damaged.
MULTUM_EXPORT(multum_open) MultumPackedField* multum_open(const std::uint8_t* bytes, std::size_t size);
MULTUM_EXPORT(multum_close) void multum_close(MultumPackedField* field);
/// Returns the reason why the last open or decode returned null, as null-terminated UTF-8.
MULTUM_EXPORT(multum_problem) const char* multum_problem();

/// Return the offset of the description in the file, and its size in bytes. Both are 0 if the description is damaged or
/// missing.
MULTUM_EXPORT(multum_description_offset) std::size_t multum_description_offset(const MultumPackedField* field);
MULTUM_EXPORT(multum_description_length) std::size_t multum_description_length(const MultumPackedField* field);

/// Chunks are numbered from 0 in the order of the index. `chunk` must be below the chunk count.
MULTUM_EXPORT(multum_chunk_count) std::size_t multum_chunk_count(const MultumPackedField* field);
MULTUM_EXPORT(multum_chunk_layer) std::uint32_t multum_chunk_layer(const MultumPackedField* field, std::size_t chunk);
MULTUM_EXPORT(multum_chunk_block) std::uint32_t multum_chunk_block(const MultumPackedField* field, std::size_t chunk);

/// Decodes the coefficients of all images in a chunk. Returns null if the chunk is damaged. The field may be closed
/// afterwards.
MULTUM_EXPORT(multum_decode) MultumTextureChunk* multum_decode(const MultumPackedField* field, std::size_t chunk);
/// Decodes a chunk from the bytes of its section, for callers that fetch byte ranges of a file. The caller must have
/// verified the checksum.
MULTUM_EXPORT(multum_decode_section)
MultumTextureChunk* multum_decode_section(const std::uint8_t* bytes, std::size_t size);
MULTUM_EXPORT(multum_chunk_close) void multum_chunk_close(MultumTextureChunk* chunk);
/// Return the width and the height of each texture, in texels.
MULTUM_EXPORT(multum_width) std::size_t multum_width(const MultumTextureChunk* chunk);
MULTUM_EXPORT(multum_height) std::size_t multum_height(const MultumTextureChunk* chunk);
/// Returns the number of textures in the chunk.
MULTUM_EXPORT(multum_sample_count) std::size_t multum_sample_count(const MultumTextureChunk* chunk);

/// Writes the texture of a sample to `out` as [height][width][3] gamma-coded floats for red, green and blue, with 255
/// for a radiance of 1. `sample` must be below the sample count.
MULTUM_EXPORT(multum_texture) void multum_texture(const MultumTextureChunk* chunk, std::size_t sample, float* out);
/// Writes the texture as radiance in half floats, which are rounded to the nearest value. The largest value is 65504.
MULTUM_EXPORT(multum_radiance_halves)
void multum_radiance_halves(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out);

/// Returns the number of texels in all mip levels of a texture.
MULTUM_EXPORT(multum_level_texels) std::size_t multum_level_texels(const MultumTextureChunk* chunk);
/// Writes the radiance of all mip levels as [texels][3] half floats, the finest level first, as `multum unpack` does.
MULTUM_EXPORT(multum_radiance_levels)
void multum_radiance_levels(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out);
