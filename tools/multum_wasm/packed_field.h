// SPDX-License-Identifier: Apache-2.0
// The decoder of packed fields (docs/reference/packed_fields.md) as functions that WebAssembly can export: numbers and
// addresses of its memory alone. tools/wasm_decoder compiles them; packed_field.mjs is the side of JavaScript. Nothing
// here throws: where memory ends the module traps, which JavaScript sees as an exception.
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

/// `size` bytes of memory, which the caller fills, and must not release while a field is open on them; null: too many.
MULTUM_EXPORT(multum_allocate) void* multum_allocate(std::size_t size);
MULTUM_EXPORT(multum_release) void multum_release(void* memory);

/// A whole file's bytes; null where they are no packed field, or its index is damaged.
MULTUM_EXPORT(multum_open) MultumPackedField* multum_open(const std::uint8_t* bytes, std::size_t size);
MULTUM_EXPORT(multum_close) void multum_close(MultumPackedField* field);
/// UTF-8 up to a 0: why the last open or decode gave null.
MULTUM_EXPORT(multum_problem) const char* multum_problem();

/// The description as it is stored: where it begins in the file, and its bytes; 0 where it is damaged or missing.
MULTUM_EXPORT(multum_description_offset) std::size_t multum_description_offset(const MultumPackedField* field);
MULTUM_EXPORT(multum_description_length) std::size_t multum_description_length(const MultumPackedField* field);

/// Chunks are numbered from 0 in the index's order; `chunk` must be below the count.
MULTUM_EXPORT(multum_chunk_count) std::size_t multum_chunk_count(const MultumPackedField* field);
MULTUM_EXPORT(multum_chunk_layer) std::uint32_t multum_chunk_layer(const MultumPackedField* field, std::size_t chunk);
MULTUM_EXPORT(multum_chunk_block) std::uint32_t multum_chunk_block(const MultumPackedField* field, std::size_t chunk);

/// Coefficients of all the chunk's images; null where it is damaged. Needs the field no longer.
MULTUM_EXPORT(multum_decode) MultumTextureChunk* multum_decode(const MultumPackedField* field, std::size_t chunk);
/// The same of a chunk's section alone, whose checksum the caller has compared: for who fetches ranges of a file.
MULTUM_EXPORT(multum_decode_section)
MultumTextureChunk* multum_decode_section(const std::uint8_t* bytes, std::size_t size);
MULTUM_EXPORT(multum_chunk_close) void multum_chunk_close(MultumTextureChunk* chunk);
/// Texels of each texture.
MULTUM_EXPORT(multum_width) std::size_t multum_width(const MultumTextureChunk* chunk);
MULTUM_EXPORT(multum_height) std::size_t multum_height(const MultumTextureChunk* chunk);
/// Textures that the chunk has.
MULTUM_EXPORT(multum_sample_count) std::size_t multum_sample_count(const MultumTextureChunk* chunk);

/// Writes the texture of a sample below the count to `out`, [height][width][3], red, green, blue: gamma-coded floats,
/// 255 for a radiance of 1.
MULTUM_EXPORT(multum_texture) void multum_texture(const MultumTextureChunk* chunk, std::size_t sample, float* out);
/// The same as radiance, halves, rounded to the nearest; the largest is 65504.
MULTUM_EXPORT(multum_radiance_halves)
void multum_radiance_halves(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out);

/// Texels of all mip levels of a chunk's texture.
MULTUM_EXPORT(multum_level_texels) std::size_t multum_level_texels(const MultumTextureChunk* chunk);
/// Radiance of all mip levels, the finest first, halves, as `multum unpack` writes them; [texels][3].
MULTUM_EXPORT(multum_radiance_levels)
void multum_radiance_levels(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out);
