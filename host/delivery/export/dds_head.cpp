// SPDX-License-Identifier: Apache-2.0
#include "host/delivery/export/dds_head.h"

#include <string_view>

#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

// The flag bits (DDSD_CAPS and so on) of the header, of its pixel format and of its caps.
constexpr std::uint32_t kHasCaps = 0x1, kHasHeight = 0x2, kHasWidth = 0x4, kHasPitch = 0x8, kHasPixelFormat = 0x1000,
                        kHasMipCount = 0x20000, kHasLinearSize = 0x80000;
constexpr std::uint32_t kIsFourCharacterCode = 0x4;
constexpr std::uint32_t kComplex = 0x8, kTexture = 0x1000, kMipMap = 0x400000;
constexpr std::uint32_t kTexture2d = 3, kAlphaUnknown = 0, kAlphaOpaque = 3, kAlphaCustom = 4;

}  // namespace

TextureHead dds_head(const LeveledTexture& texture) {
  const TexelFormatInfo& info = info_of(texture.format);
  const bool has_blocks = info.block_side > 1;
  ByteList list;
  const auto add = [&](std::uint64_t value) { list.add(value, 4); };
  const auto add_zeros = [&](int count) { list.bytes.insert(list.bytes.end(), 4 * size_of(count), 0); };
  const auto add_code = [&](std::string_view code) { list.bytes.insert(list.bytes.end(), code.begin(), code.end()); };
  add_code("DDS ");
  add(124);
  add(kHasCaps | kHasHeight | kHasWidth | kHasPixelFormat | kHasMipCount | (has_blocks ? kHasLinearSize : kHasPitch));
  add(size_of(texture.height));
  add(size_of(texture.width));
  add(has_blocks ? level_bytes(texture, 0) : block_row_bytes(texture, 0));
  add(0);
  add(size_of(texture.level_count));
  add_zeros(11);
  add(32);
  add(kIsFourCharacterCode);
  add_code("DX10");
  add_zeros(5);
  add(kTexture | (texture.level_count > 1 ? kComplex | kMipMap : 0));
  add_zeros(4);
  add(info.dxgi_format);
  add(kTexture2d);
  add(0);
  add(1);
  add(info.channels != 4 ? kAlphaUnknown : texture.alpha_is_data ? kAlphaCustom : kAlphaOpaque);

  TextureHead head;
  std::uint64_t at = list.bytes.size();
  for (int level = 0; level < texture.level_count; ++level) {
    head.level_offsets.push_back(at);
    at += level_bytes(texture, level);
  }
  head.bytes = std::move(list.bytes);
  return head;
}

}  // namespace multum
