// SPDX-License-Identifier: Apache-2.0
// Fuzzes the decoder of compressed animations: indexes of packed fields, and texture chunks. The decoder refuses
// invalid data with a reason and without exceptions. Also fuzzes the reader of descriptions, which needs more libraries
// and refuses invalid descriptions with an Error.
#include <zlib.h>

#include "host/fields/codec/byte_writer.h"
#include "host/fields/codec/chunk_choice.h"
#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/decoder/section_checksum.h"
#include "host/fields/codec/field_description.h"
#include "host/fields/codec/packed_file.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

/// Returns a chunk of a few texels. One of the coders has coded them as a pyramid or as coefficients of a basis.
std::vector<std::uint8_t> small_chunk(ImageCoder coder, bool has_basis) {
  ChunkSource source;
  source.width = 21;
  source.height = 9;
  source.sizes = {3, 2};
  for (std::size_t s = 0; s < 6; ++s) {
    std::vector<float> texture(3 * 21 * 9);
    for (std::size_t i = 0; i < texture.size(); ++i) texture[i] = static_cast<float>((i * (s + 3) * 7) % 251);
    source.textures.push_back(std::move(texture));
  }
  source.texel_weights.assign(21 * 9, 1.0f);
  const std::size_t coefficients = coder == ImageCoder::kDct ? 3 * 2 * 64 : 21 * 9;
  const auto weights = [coefficients](std::size_t) { return std::vector<float>(coefficients, 1.0f); };
  ChunkSettings settings;
  settings.coder = coder;
  settings.side = 8;
  settings.lambda = 100.0;
  settings.basis_images = 2;
  if (!has_basis) settings.levels = plain_levels(source.sizes);
  return ChunkEncoder(source, weights, coder, settings.side).encode(settings, [] {}).bytes;
}

std::string seed(char kind, const std::vector<std::uint8_t>& bytes) {
  return kind + std::string(bytes.begin(), bytes.end());
}

void decode_index(std::span<const std::uint8_t> bytes) {
  std::string problem;
  const auto index = PackedIndex::read(bytes, problem);
  MULTUM_CHECK(index || !problem.empty());
  if (!index) return;
  std::uint64_t end = 0;
  for (const PackedSection& section : index->sections()) {
    MULTUM_CHECK(section.offset >= end);
    end = section.offset + section.length;
  }
  MULTUM_CHECK(end <= index->file_bytes());
}

/// Corrects the checksum of an index and decodes the index. Without the correction, the checksum of a mutated index
/// would almost never match.
void decode_mended_index(std::vector<std::uint8_t> bytes) {
  std::string problem;
  const auto needed = PackedIndex::bytes_needed(bytes, problem);
  if (needed && *needed <= bytes.size()) {
    const std::uint32_t sum = section_checksum(std::span<const std::uint8_t>(bytes).first(*needed - 4));
    for (std::size_t i = 0; i < 4; ++i) bytes[*needed - 4 + i] = static_cast<std::uint8_t>(sum >> (8 * i));
  }
  decode_index(bytes);
}

void decode_chunk(std::span<const std::uint8_t> bytes) {
  constexpr std::size_t kTexelsMax = 1 << 12;  // limit per texture; larger textures are slow and show nothing new
  std::string problem;
  ByteReader reader(bytes);
  const auto format = read_chunk_format(reader, problem);
  MULTUM_CHECK(format || !problem.empty());
  if (!format) return;
  MULTUM_CHECK(format->plan().has_value());
  if (format->width * format->height * format->plan()->image_count() > 16 * kTexelsMax) return;
  const auto chunk = TextureChunk::decode(bytes, problem);
  MULTUM_CHECK(chunk != nullptr && chunk->sample_count() > 0);
  if (format->width * format->height > kTexelsMax) return;
  const auto texture = chunk->texture(chunk->sample_count() - 1);
  MULTUM_CHECK(texture.size() == 3 * format->width * format->height);
  mip_levels(format->width, format->height, texture);
  // Makes the requests that a player would make: single images and a sum of images, all within the limits.
  MULTUM_CHECK(chunk->image(chunk->plan().image_count() - 1).size() == texture.size());
  MULTUM_CHECK(chunk->image_sum(0).size() == texture.size());
  bool ran_out = false;
  const auto limited = TextureChunk::decode(bytes, problem, {chunk->memory_bytes() / 2, nullptr, &ran_out});
  MULTUM_CHECK(limited != nullptr || ran_out);
  MULTUM_CHECK(limited == nullptr || limited->memory_bytes() <= chunk->memory_bytes() / 2);
}

/// Returns a description with 3 views, 2 lights and two objects, one of which moves. One layer varies with both
/// parameters, and one layer is sometimes out of sight.
FieldDescription small_description() {
  FieldDescription description;
  InferredManifest& field = description.field;
  field.geometry_file = "scene.glb";
  field.geometry_hash = std::string(64, 'a');
  field.width = 32;
  field.height = 24;
  field.supersampling = 4;
  field.parameters = {"view", "light"};
  field.objects.resize(2);
  for (std::size_t k = 0; k < 2; ++k) {
    InferredObject& object = field.objects[k];
    object.name = object.mesh = k == 0 ? "wall" : "vase \u00e9";
    object.mappings.resize(2);
    object.mappings[0].width = object.mappings[1].height = 21;
  }
  for (int view = 0; view < 3; ++view)
    for (int light = 0; light < 2; ++light) {
      InferredSample sample;
      sample.name = std::to_string(view) + "_" + std::to_string(light);
      sample.at = {view, light};
      sample.world_to_clip[3][0] = 0.1 * view;
      if (light == 1) sample.object_to_world["wall"][3][1] = 1e-3;
      field.samples.push_back(sample);
      for (InferredObject& object : field.objects) object.mapping_of_sample.push_back(view / 2);
    }
  description.layers = {{0, "gloss", {{{0, 0}, {2, 2}, {0, 1}}, {{2, 0}, {1, 2}, {1}}}, {1, 4}},
                        {1, "diffuse", {{{0, 0}, {3, 1}, {0}}, {{0, 1}, {3, 1}, {}}}, {}}};
  return description;
}

/// Returns the uncompressed text of a description. Mutations of the text that zlib has compressed would only break its
/// checksum.
std::string description_text(const std::vector<std::uint8_t>& section) {
  ByteReader reader(section);
  std::string text(reader.number(1 << 20), '\0');
  auto length = static_cast<uLongf>(text.size());
  const auto packed = reader.bytes(reader.left());
  MULTUM_CHECK(uncompress(reinterpret_cast<Bytef*>(text.data()), &length, packed.data(),
                          static_cast<uLong>(packed.size())) == Z_OK);
  return text;
}

std::vector<std::uint8_t> packed_text(const std::vector<std::uint8_t>& text) {
  std::vector<Bytef> packed(compressBound(static_cast<uLong>(text.size())));
  auto length = static_cast<uLongf>(packed.size());
  MULTUM_CHECK(compress2(packed.data(), &length, text.data(), static_cast<uLong>(text.size()), Z_BEST_SPEED) == Z_OK);
  ByteWriter writer;
  writer.number(text.size());
  writer.bytes(std::span(packed).first(length));
  return writer.written();
}

/// Checks that an accepted description is consistent, because players rely on this.
void read_description(std::span<const std::uint8_t> bytes) {
  fuzz::may_refuse([&] {
    const FieldDescription description = decode_description(bytes);
    const InferredManifest& field = description.field;
    for (const InferredSample& sample : field.samples)
      MULTUM_CHECK(description.grid.position_of(sample.at) < field.samples.size());
    for (const InferredObject& object : field.objects)
      for (std::size_t s = 0; s < field.samples.size(); ++s) {
        const TextureMapping& mapping = object.mappings.at(static_cast<std::size_t>(object.mapping_of_sample.at(s)));
        MULTUM_CHECK(mapping.width >= 1 && mapping.height >= 1);
      }
    for (const PackedLayer& layer : description.layers) {
      MULTUM_CHECK(layer.object < field.objects.size());
      std::size_t covered = 0;
      for (const FieldBlock& block : layer.blocks) {
        std::size_t textures = 1;
        for (const std::size_t size : block.chunk_sizes()) textures *= size;
        for (const std::size_t s : description.grid.samples_in(block)) {
          MULTUM_CHECK(block.chunk_sample(field.samples.at(s).at) < textures);
          ++covered;
        }
      }
      MULTUM_CHECK(covered == field.samples.size());
      for (const int sample : layer.unseen) MULTUM_CHECK(static_cast<std::size_t>(sample) < field.samples.size());
    }
  });
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const auto chunk = small_chunk(ImageCoder::kDct, false);
  const auto description = encode_description(small_description());
  const auto file = packed_file({{0, 0, 0, {1, 2, 3}}, {1, 0, 0, chunk}, {1, 3, 200, {}}});
  return {seed(0, file),
          seed(1, file),
          seed(2, chunk),
          seed(2, small_chunk(ImageCoder::kDct, true)),
          seed(2, small_chunk(ImageCoder::kWavelet, false)),
          seed(2, small_chunk(ImageCoder::kWavelet, true)),
          seed(3, description),
          char(4) + description_text(description)};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const fuzz::Input input = fuzz::split(data, size, 5);
  const std::vector<std::uint8_t> bytes(input.bytes.begin(), input.bytes.end());
  if (input.kind == 0) decode_index(bytes);
  if (input.kind == 1) decode_mended_index(bytes);
  if (input.kind == 2) decode_chunk(bytes);
  if (input.kind == 3) read_description(bytes);
  if (input.kind == 4) read_description(packed_text(bytes));
  return 0;
}
