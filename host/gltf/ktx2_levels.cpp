// SPDX-License-Identifier: Apache-2.0
#include "host/gltf/ktx2_levels.h"

#include <zstd.h>

#include <string_view>

#include "host/base/error.h"
#include "host/base/files/output_file.h"
#include "host/base/size_of.h"
#include "host/base/version.h"

namespace multum {
namespace {

// Basis Universal's own choice is 6; the levels above it take several times the time for some percent.
constexpr int kZstdLevel = 12;
constexpr std::uint64_t kHeadBytes = 80, kIndexEntryBytes = 24;

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>((value >> (8 * i)) & 255);
}

// A basic descriptor block (Khronos Data Format Specification 1.3, section 5).
std::string texel_descriptor(Ktx2Texels texels) {
  const bool is_uastc = texels == Ktx2Texels::kUastc;
  constexpr std::uint32_t kRgbModel = 1, kUastcModel = 166, kLinear = 1, kVersion = 2, kAlpha = 15;
  const std::uint32_t samples = is_uastc ? 1 : 4;
  std::string out;
  put(out, 4 + 24 + 16 * samples, 4);
  put(out, 0, 4);  // Khronos, basic
  put(out, kVersion, 2);
  put(out, 24 + 16 * samples, 2);
  put(out, is_uastc ? kUastcModel : kRgbModel, 1);
  put(out, 0, 1);  // no primaries
  put(out, kLinear, 1);
  put(out, 0, 1);
  put(out, is_uastc ? 0x0303 : 0, 4);  // sides of a block less 1
  put(out, is_uastc ? 16 : 4, 8);      // bytes of planes
  for (std::uint32_t c = 0; c < samples; ++c) {
    put(out, 8 * c, 2);
    put(out, is_uastc ? 127 : 7, 1);   // bits less 1
    put(out, c == 3 ? kAlpha : c, 1);  // of UASTC 0 is RGB
    put(out, 0, 4);                    // place in the block
    put(out, 0, 4);                    // the least code
    put(out, is_uastc ? 0xffffffffu : 255, 4);
  }
  return out;
}

std::string file_keys() {
  std::string out;
  const auto add = [&](std::string_view key, std::string_view value) {
    put(out, key.size() + value.size() + 2, 4);
    out.append(key).append(1, '\0').append(value).append(1, '\0');
    while (out.size() % 4 != 0) out += '\0';
  };
  add("KTXorientation", "rd");
  add("KTXwriter", software_version());
  return out;
}

std::vector<std::uint8_t> compressed(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint8_t> made(ZSTD_compressBound(bytes.size()));
  const std::size_t size = ZSTD_compress(made.data(), made.size(), bytes.data(), bytes.size(), kZstdLevel);
  MULTUM_CHECK(!ZSTD_isError(size));
  made.resize(size);
  return made;
}

struct StoredLevel {
  std::uint64_t offset = 0, stored = 0, whole = 0;
};

std::string file_head(const Ktx2LevelsSettings& settings, const std::vector<StoredLevel>& levels) {
  const std::string descriptor = texel_descriptor(settings.texels), keys = file_keys();
  constexpr std::uint32_t kRgba8Unorm = 37, kZstandard = 2;
  const std::uint64_t descriptor_at = kHeadBytes + kIndexEntryBytes * levels.size();
  std::string out("\xabKTX 20\xbb\r\n\x1a\n", 12);
  put(out, settings.texels == Ktx2Texels::kRgba8 ? kRgba8Unorm : 0, 4);
  put(out, 1, 4);
  put(out, size_of(settings.width), 4);
  put(out, size_of(settings.height), 4);
  put(out, 0, 4);  // no depth
  put(out, 0, 4);  // no array
  put(out, 1, 4);  // face
  put(out, levels.size(), 4);
  put(out, settings.is_supercompressed ? kZstandard : 0, 4);
  put(out, descriptor_at, 4);
  put(out, descriptor.size(), 4);
  put(out, descriptor_at + descriptor.size(), 4);
  put(out, keys.size(), 4);
  put(out, 0, 8);  // no global data
  put(out, 0, 8);
  for (const StoredLevel& level : levels)
    for (const std::uint64_t value : {level.offset, level.stored, level.whole}) put(out, value, 8);
  return out + descriptor + keys;
}

}  // namespace

std::uint64_t write_ktx2_levels(const std::string& path, const Ktx2LevelsSettings& settings,
                                const std::function<std::vector<std::uint8_t>(int level)>& level_bytes) {
  OutputFile file(path, path);
  std::vector<StoredLevel> levels(size_of(settings.level_count));
  // Of levels that are not supercompressed: a texel, or a block.
  const std::uint64_t alignment = settings.texels == Ktx2Texels::kRgba8 ? 4 : 16;
  std::uint64_t at = file_head(settings, levels).size();   // whose length is known before what is in it
  for (std::size_t level = levels.size(); level-- > 0;) {  // the smallest first
    std::vector<std::uint8_t> bytes = level_bytes(static_cast<int>(level));
    const std::uint64_t whole = bytes.size();
    if (settings.is_supercompressed) bytes = compressed(bytes);
    else at = (at + alignment - 1) / alignment * alignment;
    levels[level] = {at, bytes.size(), whole};
    if (file.seek(at)) file.write(bytes.data(), bytes.size());
    at += bytes.size();
  }
  const std::string head = file_head(settings, levels);
  if (file.seek(0)) file.write(head.data(), head.size());
  file.close();
  return at;
}

}  // namespace multum
