// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/ktx2_head.h"

#include <numeric>

#include "host/foundation/base/error.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::uint8_t kIdentifier[] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};
constexpr std::uint32_t kZstandard = 2;  // supercompression scheme

// A sample of a basic descriptor block: channel, bit count and first bit. In block formats, a sample spans all bits.
struct DescribedSample {
  std::uint32_t channel, first_bit, bit_count;
};

// Returns the KHR_DF_MODEL value. RGBSDA is 1, and block formats have their own models.
std::uint32_t colour_model(TexelFormat format) {
  switch (format) {
    case TexelFormat::kBc4: return 131;
    case TexelFormat::kBc5: return 132;
    case TexelFormat::kBc7: return 134;
    case TexelFormat::kUastc:
    case TexelFormat::kUastcAlpha: return 166;
    default: return 1;
  }
}

bool is_uastc(TexelFormat format) { return format == TexelFormat::kUastc || format == TexelFormat::kUastcAlpha; }

std::vector<DescribedSample> samples_of(TexelFormat format) {
  constexpr std::uint32_t kAlphaChannel = 15, kUastcRgba = 3;
  const TexelFormatInfo& info = info_of(format);
  // A BC5 block consists of two BC4 blocks. BC7 and UASTC blocks hold all channels together.
  const bool is_whole = format == TexelFormat::kBc7 || is_uastc(format);
  const std::uint32_t count = is_whole ? 1u : static_cast<std::uint32_t>(info.channels);
  const std::uint32_t bits = 8 * static_cast<std::uint32_t>(info.block_bytes) / count;
  std::vector<DescribedSample> samples;
  if (format == TexelFormat::kUastcAlpha) return {{kUastcRgba, 0, bits}};
  for (std::uint32_t c = 0; c < count; ++c) samples.push_back({c == 3 ? kAlphaChannel : c, bits * c, bits});
  return samples;
}

// Makes a basic descriptor block (Khronos Data Format Specification 1.3, section 5) for one texel or a block of 4 x 4
// texels. It states linear RGB with BT.709 primaries and straight alpha. KHR_texture_basisu forbids primaries for data
// that is not colour.
ByteList format_descriptor(TexelFormat format) {
  constexpr std::uint32_t kLinearTransfer = 1, kVersion = 2;
  constexpr std::uint32_t kSignedFloat = 0xc0;  // bits of a channel's type
  const std::uint32_t primaries = is_uastc(format) ? 0 : 1;
  const TexelFormatInfo& info = info_of(format);
  const std::vector<DescribedSample> samples = samples_of(format);
  const std::size_t block_bytes = 24 + 16 * samples.size();
  ByteList list;
  list.add(4 + block_bytes, 4);
  list.add(0, 4);  // Khronos, basic
  list.add(kVersion, 2);
  list.add(block_bytes, 2);
  for (const std::uint32_t value : {colour_model(format), primaries, kLinearTransfer, 0u}) list.add(value, 1);
  for (const int side : {info.block_side, info.block_side, 1, 1}) list.add(size_of(side - 1), 1);
  // The bytesPlane values 0 to 7 are those of data without supercompression (KTX 2.0, revision 4).
  list.add(size_of(info.block_bytes), 8);
  const std::uint32_t most = info.is_float ? 0x3f800000u : info.block_side > 1 ? 0xffffffffu : 255u;  // 1
  for (const DescribedSample& sample : samples) {
    list.add(sample.first_bit, 2);
    list.add(sample.bit_count - 1, 1);
    list.add(sample.channel | (info.is_float ? kSignedFloat : 0u), 1);
    list.add(0, 4);                                 // position in the block
    list.add(info.is_float ? 0xbf800000u : 0u, 4);  // -1, or 0
    list.add(most, 4);
  }
  return list;
}

// Writes the pairs sorted by key.
ByteList key_values(const Ktx2Settings& settings) {
  ByteList list;
  const auto add = [&](const std::string& key, const std::string& value) {
    list.add(key.size() + value.size() + 2, 4);
    list.add_text(key);
    list.add_text(value);
    list.pad_to(4);
  };
  add("KTXorientation", "rd");
  if (!settings.swizzle.empty()) add("KTXswizzle", settings.swizzle);
  add("KTXwriter", settings.writer);
  for (const Ktx2Key& one : settings.keys) add(one.key, one.value);
  return list;
}

}  // namespace

TextureHead ktx2_head(const LeveledTexture& texture, const Ktx2Settings& settings) {
  const TexelFormatInfo& info = info_of(texture.format);
  const bool is_compressed = !settings.zstd_lengths.empty();
  MULTUM_CHECK(!is_compressed || settings.zstd_lengths.size() == size_of(texture.level_count));
  const auto stored_bytes = [&](int level) {
    return is_compressed ? settings.zstd_lengths[size_of(level)] : level_bytes(texture, level);
  };
  const ByteList descriptor = format_descriptor(texture.format), keys = key_values(settings);
  constexpr std::uint64_t kFixed = 80, kIndexEntry = 24;
  const std::uint64_t descriptor_at = kFixed + kIndexEntry * size_of(texture.level_count);
  const std::uint64_t keys_at = descriptor_at + descriptor.bytes.size();
  // A level begins at an offset that is a multiple of 4 and of its texel or block size. Supercompressed levels follow
  // one another without padding.
  const std::uint64_t alignment = is_compressed ? 1 : std::lcm<std::uint64_t>(size_of(info.block_bytes), 4);
  TextureHead head;
  head.level_offsets.resize(size_of(texture.level_count));
  std::uint64_t at = keys_at + keys.bytes.size();
  for (int level = texture.level_count - 1; level >= 0; --level) {
    at = (at + alignment - 1) / alignment * alignment;
    head.level_offsets[size_of(level)] = at;
    at += stored_bytes(level);
  }
  ByteList list;
  list.bytes.assign(std::begin(kIdentifier), std::end(kIdentifier));
  for (const std::uint64_t value :
       {std::uint64_t{info.vk_format}, std::uint64_t{size_of(info.type_bytes)}, std::uint64_t{size_of(texture.width)},
        std::uint64_t{size_of(texture.height)}, std::uint64_t{0}, std::uint64_t{size_of(texture.layer_count)},
        std::uint64_t{1}, std::uint64_t{size_of(texture.level_count)}, std::uint64_t{is_compressed ? kZstandard : 0u},
        descriptor_at, std::uint64_t{descriptor.bytes.size()}, keys_at, std::uint64_t{keys.bytes.size()}})
    list.add(value, 4);
  list.add(0, 8);  // no global data
  list.add(0, 8);
  for (int level = 0; level < texture.level_count; ++level) {
    list.add(head.level_offsets[size_of(level)], 8);
    list.add(stored_bytes(level), 8);
    list.add(level_bytes(texture, level), 8);
  }
  for (const ByteList* part : {&descriptor, &keys})
    list.bytes.insert(list.bytes.end(), part->bytes.begin(), part->bytes.end());
  head.bytes = std::move(list.bytes);
  return head;
}

}  // namespace multum
