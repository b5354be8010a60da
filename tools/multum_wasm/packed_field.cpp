// SPDX-License-Identifier: Apache-2.0
#include "tools/multum_wasm/packed_field.h"

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/decoder/packed_index.h"
#include "host/fields/codec/decoder/texture_chunk.h"
#include "host/foundation/base/half_bits.h"

struct MultumPackedField {
  std::span<const std::uint8_t> bytes;
  multum::PackedIndex index;
  std::vector<const multum::PackedSection*> chunks;

  std::span<const std::uint8_t> section(const multum::PackedSection& section) const {
    return bytes.subspan(static_cast<std::size_t>(section.offset), static_cast<std::size_t>(section.length));
  }
  const multum::PackedSection* description() const {
    const multum::PackedSection* found = index.find(multum::SectionKind::kDescription, 0, 0);
    return found != nullptr && is_intact(*found, section(*found)) ? found : nullptr;
  }
};

struct MultumTextureChunk {
  std::unique_ptr<multum::TextureChunk> decoded;
};

namespace {

std::string last_problem;

}  // namespace

void* multum_allocate(std::size_t size) { return std::malloc(size); }
void multum_release(void* memory) { std::free(memory); }

MultumPackedField* multum_open(const std::uint8_t* bytes, std::size_t size) {
  auto field = std::make_unique<MultumPackedField>();
  field->bytes = {bytes, size};
  auto index = multum::PackedIndex::read(field->bytes, last_problem);
  if (!index) return nullptr;
  if (index->file_bytes() != size) {
    last_problem = "the file is longer or shorter than its index says";
    return nullptr;
  }
  field->index = std::move(*index);
  for (const multum::PackedSection& section : field->index.sections())
    if (section.kind == static_cast<std::uint32_t>(multum::SectionKind::kChunk)) field->chunks.push_back(&section);
  return field.release();
}

void multum_close(MultumPackedField* field) { delete field; }
const char* multum_problem() { return last_problem.c_str(); }

std::size_t multum_description_offset(const MultumPackedField* field) {
  const multum::PackedSection* section = field->description();
  return section == nullptr ? 0 : static_cast<std::size_t>(section->offset);
}

std::size_t multum_description_length(const MultumPackedField* field) {
  const multum::PackedSection* section = field->description();
  return section == nullptr ? 0 : static_cast<std::size_t>(section->length);
}

std::size_t multum_chunk_count(const MultumPackedField* field) { return field->chunks.size(); }
std::uint32_t multum_chunk_layer(const MultumPackedField* field, std::size_t chunk) {
  return field->chunks[chunk]->layer;
}
std::uint32_t multum_chunk_block(const MultumPackedField* field, std::size_t chunk) {
  return field->chunks[chunk]->block;
}

MultumTextureChunk* multum_decode(const MultumPackedField* field, std::size_t chunk) {
  const multum::PackedSection& section = *field->chunks[chunk];
  const std::span<const std::uint8_t> bytes = field->section(section);
  if (!is_intact(section, bytes)) {
    last_problem = "the chunk is damaged: its checksum differs";
    return nullptr;
  }
  return multum_decode_section(bytes.data(), bytes.size());
}

MultumTextureChunk* multum_decode_section(const std::uint8_t* bytes, std::size_t size) {
  auto decoded = multum::TextureChunk::decode({bytes, size}, last_problem);
  if (decoded == nullptr) return nullptr;
  if (decoded->was_cut_short()) {
    last_problem = "the chunk is damaged: it ends before its last image is complete";
    return nullptr;
  }
  return new MultumTextureChunk{std::move(decoded)};
}

void multum_chunk_close(MultumTextureChunk* chunk) { delete chunk; }
std::size_t multum_width(const MultumTextureChunk* chunk) { return chunk->decoded->format().width; }
std::size_t multum_height(const MultumTextureChunk* chunk) { return chunk->decoded->format().height; }
std::size_t multum_sample_count(const MultumTextureChunk* chunk) { return chunk->decoded->sample_count(); }

void multum_texture(const MultumTextureChunk* chunk, std::size_t sample, float* out) {
  const std::vector<float> texture = chunk->decoded->texture(sample);
  std::copy(texture.begin(), texture.end(), out);
}

void multum_radiance_halves(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out) {
  const std::vector<float> texture = chunk->decoded->texture(sample);
  std::transform(texture.begin(), texture.end(), out,
                 [](float value) { return multum::clamped_to_half(multum::radiance_of(value)); });
}

std::size_t multum_level_texels(const MultumTextureChunk* chunk) {
  return multum::mip_texel_count(multum_width(chunk), multum_height(chunk));
}

void multum_radiance_levels(const MultumTextureChunk* chunk, std::size_t sample, std::uint16_t* out) {
  std::vector<float> texture = chunk->decoded->texture(sample);
  for (float& value : texture) value = multum::radiance_of(value);
  const std::vector<float> levels = multum::mip_levels(multum_width(chunk), multum_height(chunk), texture);
  std::transform(levels.begin(), levels.end(), out, multum::clamped_to_half);
}
