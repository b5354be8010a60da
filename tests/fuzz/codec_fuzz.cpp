// SPDX-License-Identifier: Apache-2.0
// The decoder of compressed animations: indexes of packed fields, and texture chunks. It throws nothing; what it cannot
// use it refuses with a reason.
#include "host/codec/chunk_choice.h"
#include "host/codec/decoder/mip_levels.h"
#include "host/codec/decoder/section_checksum.h"
#include "host/codec/packed_file.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

/// Of a few texels, by one of the coders, over a pyramid or a basis.
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
  source.coefficient_weights = [coefficients](std::size_t) { return std::vector<float>(coefficients, 1.0f); };
  ChunkSettings settings;
  settings.coder = coder;
  settings.side = 8;
  settings.lambda = 100.0;
  settings.basis_images = 2;
  if (!has_basis) settings.levels = plain_levels(source.sizes);
  return encode_chunk(source, settings).bytes;
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

/// With the checksum that the rest needs: mutations would hardly ever find it.
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
  constexpr std::size_t kTexelsMax = 1 << 12;  // of one texture: larger ones are slow, not different
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
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const auto chunk = small_chunk(ImageCoder::kDct, false);
  const auto file = packed_file({{0, 0, 0, {1, 2, 3}}, {1, 0, 0, chunk}, {1, 3, 200, {}}});
  return {seed(0, file),
          seed(1, file),
          seed(2, chunk),
          seed(2, small_chunk(ImageCoder::kDct, true)),
          seed(2, small_chunk(ImageCoder::kWavelet, false)),
          seed(2, small_chunk(ImageCoder::kWavelet, true))};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const fuzz::Input input = fuzz::split(data, size, 3);
  const std::vector<std::uint8_t> bytes(input.bytes.begin(), input.bytes.end());
  if (input.kind == 0) decode_index(bytes);
  if (input.kind == 1) decode_mended_index(bytes);
  if (input.kind == 2) decode_chunk(bytes);
  return 0;
}
