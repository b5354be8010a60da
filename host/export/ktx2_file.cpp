// SPDX-License-Identifier: Apache-2.0
#include "host/export/ktx2_file.h"

#include <numeric>
#include <string_view>

#include "host/asset/baked_file.h"
#include "host/base/error.h"
#include "host/base/size_of.h"
#include "host/base/version.h"

namespace multum {
namespace {

constexpr std::uint8_t kIdentifier[] = {0xab, 'K', 'T', 'X', ' ', '2', '0', 0xbb, '\r', '\n', 0x1a, '\n'};

// What a format is in Vulkan and in a data format descriptor (Khronos Data Format Specification 1.3, section 5).
struct FormatInfo {
  std::uint32_t vk_format;  // VkFormat
  std::uint32_t channels, channel_bytes;
  bool is_float;
};

FormatInfo info_of(Ktx2Format format) {
  switch (format) {
    case Ktx2Format::kRg8: return {16, 2, 1, false};     // VK_FORMAT_R8G8_UNORM
    case Ktx2Format::kRgba8: return {37, 4, 1, false};   // VK_FORMAT_R8G8B8A8_UNORM
    case Ktx2Format::kRgba16f: return {97, 4, 2, true};  // VK_FORMAT_R16G16B16A16_SFLOAT
  }
  return {};
}

// Little-endian numbers, one behind the other.
class ByteList {
 public:
  void add(std::uint64_t value, int byte_count) {
    for (int i = 0; i < byte_count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  void add_text(std::string_view text) {
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.push_back(0);
  }
  void pad_to(std::size_t multiple) {
    while (bytes.size() % multiple != 0) bytes.push_back(0);
  }
  std::vector<std::uint8_t> bytes;
};

// A basic descriptor block: linear RGB of BT.709's primaries, straight alpha, one texel a block; a sample a channel.
ByteList format_descriptor(const FormatInfo& info) {
  constexpr std::uint32_t kRgbModel = 1, kPrimaries = 1, kLinearTransfer = 1, kVersion = 2, kAlphaChannel = 15;
  constexpr std::uint32_t kSignedFloat = 0xc0;  // bits of a channel's type
  const std::uint32_t block_bytes = 24 + 16 * info.channels;
  ByteList list;
  list.add(4 + block_bytes, 4);
  list.add(0, 4);  // Khronos, basic
  list.add(kVersion, 2);
  list.add(block_bytes, 2);
  for (const std::uint32_t value : {kRgbModel, kPrimaries, kLinearTransfer, 0u}) list.add(value, 1);
  list.add(0, 4);                                   // sides of a block less 1
  list.add(info.channels * info.channel_bytes, 8);  // bytes of planes 0 to 7
  for (std::uint32_t c = 0; c < info.channels; ++c) {
    list.add(8 * info.channel_bytes * c, 2);
    list.add(8 * info.channel_bytes - 1, 1);
    list.add((c == 3 ? kAlphaChannel : c) | (info.is_float ? kSignedFloat : 0u), 1);
    list.add(0, 4);                                   // place in the block
    list.add(info.is_float ? 0xbf800000u : 0u, 4);    // -1, or 0
    list.add(info.is_float ? 0x3f800000u : 255u, 4);  // 1
  }
  return list;
}

// Sorted by key.
ByteList key_values(const std::string& writer) {
  ByteList list;
  const auto add = [&](const std::string& key, const std::string& value) {
    list.add(key.size() + value.size() + 2, 4);
    list.add_text(key);
    list.add_text(value);
    list.pad_to(4);
  };
  add("KTXorientation", "rd");
  add("KTXwriter", writer);
  return list;
}

std::uint64_t row_bytes(const Ktx2Texture& texture, int level) {
  return size_of(mip_level_size(texture.width, level)) * texel_bytes(texture.format);
}

std::uint64_t level_bytes(const Ktx2Texture& texture, int level) {
  return row_bytes(texture, level) * size_of(mip_level_size(texture.height, level));
}

}  // namespace

std::size_t texel_bytes(Ktx2Format format) {
  const FormatInfo info = info_of(format);
  return info.channels * info.channel_bytes;
}

Ktx2Head ktx2_head(const Ktx2Texture& texture, const std::string& writer) {
  const FormatInfo info = info_of(texture.format);
  const ByteList descriptor = format_descriptor(info), keys = key_values(writer);
  constexpr std::uint64_t kFixed = 80, kIndexEntry = 24;
  const std::uint64_t descriptor_at = kFixed + kIndexEntry * size_of(texture.level_count);
  const std::uint64_t keys_at = descriptor_at + descriptor.bytes.size();
  // A level begins at a multiple of its texel and of 4.
  const std::uint64_t alignment = std::lcm<std::uint64_t>(texel_bytes(texture.format), 4);
  Ktx2Head head;
  head.level_offsets.resize(size_of(texture.level_count));
  std::uint64_t at = keys_at + keys.bytes.size();
  for (int level = texture.level_count - 1; level >= 0; --level) {
    at = (at + alignment - 1) / alignment * alignment;
    head.level_offsets[size_of(level)] = at;
    at += level_bytes(texture, level);
  }
  ByteList list;
  list.bytes.assign(std::begin(kIdentifier), std::end(kIdentifier));
  for (const std::uint64_t value :
       {std::uint64_t{info.vk_format}, std::uint64_t{info.channel_bytes}, std::uint64_t{size_of(texture.width)},
        std::uint64_t{size_of(texture.height)}, std::uint64_t{0}, std::uint64_t{0}, std::uint64_t{1},
        std::uint64_t{size_of(texture.level_count)}, std::uint64_t{0}, descriptor_at,
        std::uint64_t{descriptor.bytes.size()}, keys_at, std::uint64_t{keys.bytes.size()}})
    list.add(value, 4);
  list.add(0, 8);  // no global data
  list.add(0, 8);
  for (int level = 0; level < texture.level_count; ++level) {
    list.add(head.level_offsets[size_of(level)], 8);
    list.add(level_bytes(texture, level), 8);
    list.add(level_bytes(texture, level), 8);
  }
  for (const ByteList* part : {&descriptor, &keys})
    list.bytes.insert(list.bytes.end(), part->bytes.begin(), part->bytes.end());
  head.bytes = std::move(list.bytes);
  return head;
}

Ktx2File::Ktx2File(const std::string& path, const Ktx2Texture& texture)
    : file_(path),
      bytes_(file_.temporary_path(), path),
      texture_(texture),
      head_(ktx2_head(texture, software_version())),
      rows_(size_of(texture.level_count), 0) {
  bytes_.write(head_.bytes.data(), head_.bytes.size());
}

void Ktx2File::write_rows(int level, int row_count, const void* texels) {
  int& row = rows_[size_of(level)];
  MULTUM_CHECK(row + row_count <= mip_level_size(texture_.height, level));
  const std::uint64_t bytes = row_bytes(texture_, level);
  // Gaps between levels are zeros: a file is, where it was never written.
  if (bytes_.seek(head_.level_offsets[size_of(level)] + bytes * size_of(row)))
    bytes_.write(texels, static_cast<std::size_t>(bytes) * size_of(row_count));
  row += row_count;
}

void Ktx2File::finish() {
  for (int level = 0; level < texture_.level_count; ++level)
    MULTUM_CHECK(rows_[size_of(level)] == mip_level_size(texture_.height, level));
  bytes_.close();
  file_.commit();
}

}  // namespace multum
