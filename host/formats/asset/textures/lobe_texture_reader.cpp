// SPDX-License-Identifier: Apache-2.0
// Reads KTX2 files, but only those that hold lobes. Checks every number before using it as a size.
#include <fmt/format.h>
#include <zstd.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "host/formats/asset/textures/lobe_texture.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/byte_file.h"
#include "host/foundation/base/files/json_file.h"
#include "host/foundation/base/files/regular_file.h"
#include "host/foundation/base/half_bits.h"
#include "host/foundation/base/path_text.h"
#include "host/foundation/base/size_of.h"

namespace multum {
namespace {

constexpr std::string_view kIdentifier("\xabKTX 20\xbb\r\n\x1a\n", 12);
constexpr int kSideMax = 32768;
constexpr std::int64_t kKeysMax = std::int64_t{16} << 20, kIndexAt = 80, kIndexEntry = 24;
constexpr std::int64_t kZstandard = 2;
// A block of Zstandard has at least 4 bytes, and holds at most 128 KiB (RFC 8878, section 3.1.1.2).
constexpr std::uint64_t kZstandardBlockLeast = 4, kZstandardBlockMost = std::uint64_t{128} << 10;

[[noreturn]] void refuse_texture(const std::string& path, const std::string& found, const std::string& expected) {
  refuse_file(path, fmt::format("found {}, expected {}", found, expected));
}

std::string lobes_key(ByteFile& file, const std::string& path) {
  const std::int64_t begin = file.little_endian(56, 4, "the key/value data"),
                     size = file.little_endian(60, 4, "the size of the key/value data");
  if (size > kKeysMax) refuse_texture(path, fmt::format("{} bytes of key/value data", size), "at most 16 MiB");
  const std::string data = file.bytes(begin, size, "the key/value data");
  for (std::size_t at = 0; at + 4 <= data.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length |= std::size_t{static_cast<unsigned char>(data[at + i])} << (8 * i);
    if (length > data.size() - at - 4) refuse_texture(path, "a key longer than the key/value data", "a complete key");
    std::string entry = data.substr(at + 4, length);
    const std::size_t end = entry.find('\0');
    if (end != std::string::npos && entry.substr(0, end) == kLobeTextureKey) {
      entry.erase(0, end + 1);
      while (!entry.empty() && entry.back() == '\0') entry.pop_back();
      return entry;
    }
    at += 4 + (length + 3) / 4 * 4;
  }
  refuse_texture(path, fmt::format("no key {}", kLobeTextureKey), "a file written by multum export --lobes");
}

LobeTexels texels_of_format(std::int64_t vk_format, const std::string& path) {
  switch (vk_format) {
    case 37: return LobeTexels::kRgba8;    // VK_FORMAT_R8G8B8A8_UNORM
    case 97: return LobeTexels::kRgba16f;  // VK_FORMAT_R16G16B16A16_SFLOAT
    case 141: return LobeTexels::kBlocks;  // VK_FORMAT_BC5_UNORM_BLOCK
    default: break;
  }
  refuse_texture(path, fmt::format("texels of VkFormat {}", vk_format), "37, 97 or 141: RGBA8, RGBA16F or BC5");
}

glm::vec4 unpacking_vector(const nlohmann::json& json) {
  glm::vec4 v(0.0f);
  for (int i = 0; i < 4; ++i) {
    v[i] = json.at(size_of(i)).get<float>();
    if (!std::isfinite(v[i])) throw std::out_of_range("a number is not finite");
  }
  return v;
}

WrapMode wrap_of_name(const nlohmann::json& json) {
  const auto mode = parse_wrap_mode(json.get<std::string>());
  if (!mode) throw std::out_of_range("an unknown wrap mode");
  return *mode;
}

void parse_texture_header(const nlohmann::json& json, LobeTextureHeader& header) {
  BakedHeader& map = header.map;
  if (json_int(json, "version") != kLobeTextureVersion) throw std::out_of_range("unknown version");
  map.width = json_int(json, "mapWidth");
  map.height = json_int(json, "mapHeight");
  map.first_level = json_int(json, "firstLevel");
  map.wrap_s = wrap_of_name(json.at("wrapS"));
  map.wrap_t = wrap_of_name(json.at("wrapT"));
  if (json_int(json, "layersPerLobe") != layers_per_lobe(header.texels))
    throw std::out_of_range("'layersPerLobe' does not match the texel format");
  for (const nlohmann::json& one : json.at("lobes")) {
    LobeUnpacking& lobe = header.lobes.emplace_back();
    if (one.at("columns").size() != lobe.columns.size()) throw std::out_of_range("'columns' does not have 4 entries");
    for (std::size_t c = 0; c < lobe.columns.size(); ++c) lobe.columns[c] = unpacking_vector(one.at("columns")[c]);
    lobe.offset = unpacking_vector(one.at("offset"));
  }
  map.has_roughness = json.contains("meanCosine");
  if (map.has_roughness) map.mean_cosine = json["meanCosine"].get<float>();
  const nlohmann::json& source = json.at("source");
  map.provenance.source_name = path_of_text(source.at("name").get<std::string>());
  map.provenance.source_hash = source.at("sha256").get<std::string>();
  map.provenance.settings = source.at("settings").get<std::string>();
  map.provenance.content_hash = source.at("contentHash").get<std::string>();
}

void check_texture_header(const LobeTextureHeader& header, const std::string& path) {
  const BakedHeader& map = header.map;
  const auto within = [](int value, int low, int high) { return value >= low && value <= high; };
  if (!within(map.width, 1, kSideMax) || !within(map.height, 1, kSideMax))
    refuse_texture(path, fmt::format("a map of {} x {}", map.width, map.height),
                   fmt::format("sides of 1 to {}", kSideMax));
  if (!within(map.first_level, 1, map.level_count() - 1))
    refuse_texture(path, fmt::format("first level {}", map.first_level), fmt::format("1 to {}", map.level_count() - 1));
  if (!within(static_cast<int>(header.lobes.size()), 1, kLobeCountMax))
    refuse_texture(path, fmt::format("{} lobes", header.lobes.size()), fmt::format("1 to {}", kLobeCountMax));
  if (map.has_roughness && !(map.mean_cosine > 0.0f && map.mean_cosine <= 1.0f))
    refuse_texture(path, fmt::format("meanCosine {}", map.mean_cosine), "above 0, at most 1");
}

// Checks that the sizes in the KTX2 header equal those in the key.
void check_texture_sizes(ByteFile& file, const LobeTextureHeader& header, const std::string& path) {
  const std::pair<const char*, std::int64_t> numbers[] = {
      {"width", mip_level_size(header.map.width, header.map.first_level)},
      {"height", mip_level_size(header.map.height, header.map.first_level)},
      {"depth", 0},
      {"layers", header.layer_count()},
      {"faces", 1},
      {"levels", header.level_count()}};
  std::int64_t at = 20;
  for (const auto& [name, expected] : numbers) {
    const std::int64_t found = file.little_endian(at, 4, name);
    if (found != expected) refuse_texture(path, fmt::format("{} {}", name, found), std::to_string(expected));
    at += 4;
  }
  const std::int64_t scheme = file.little_endian(44, 4, "the supercompression");
  if (scheme != 0 && scheme != kZstandard)
    refuse_texture(path, fmt::format("supercompression {}", scheme), "none, or Zstandard (2)");
}

LobeTextureHeader read_texture_header(ByteFile& file, const std::string& path) {
  if (file.size() < kIndexAt || file.bytes(0, 12, "the identifier") != kIdentifier)
    refuse_texture(path, "no KTX2 identifier", "a KTX2 file of lobes (multum export --lobes)");
  LobeTextureHeader header;
  header.texels = texels_of_format(file.little_endian(12, 4, "the format"), path);
  const std::string text = lobes_key(file, path);
  try {
    if (holds_nul(text)) throw std::out_of_range("a NUL in a text");
    parse_texture_header(nlohmann::json::parse(text), header);
  } catch (const std::exception& error) {
    refuse_file(path, fmt::format("cannot read {}: {}", kLobeTextureKey, error.what()));
  }
  check_texture_header(header, path);
  check_texture_sizes(file, header, path);
  return header;
}

std::vector<std::uint8_t> read_texture_level(ByteFile& file, const LobeTextureHeader& header, int level,
                                             const std::string& path) {
  const std::int64_t at = kIndexAt + kIndexEntry * level;
  const std::int64_t begin = file.little_endian(at, 8, "the level index"), size = file.little_endian(at + 8, 8, "it"),
                     stated = file.little_endian(at + 16, 8, "it");
  const int map_level = header.map.first_level + level;
  const std::uint64_t bytes =
      size_of(header.layer_count()) * layer_bytes(header.texels, mip_level_size(header.map.width, map_level),
                                                  mip_level_size(header.map.height, map_level));
  const bool is_compressed = file.little_endian(44, 4, "the supercompression") == kZstandard;
  if (static_cast<std::uint64_t>(stated) != bytes || (!is_compressed && size != stated))
    refuse_texture(path, fmt::format("{} bytes of level {}", stated, level), std::to_string(bytes));
  if (begin < 0 || size < 0 || begin > file.size() || size > file.size() - begin)
    refuse_texture(path, fmt::format("level {} beyond the end of the file", level), "a complete level");
  const std::string stored = file.bytes(begin, size, "a level");
  if (!is_compressed) return {stored.begin(), stored.end()};
  // Checked before memory is allocated, because a short file can state any size.
  if (bytes / kZstandardBlockMost > stored.size() / kZstandardBlockLeast)
    refuse_texture(path, fmt::format("{} compressed bytes of level {}", size, level), fmt::format("{} bytes", bytes));
  std::vector<std::uint8_t> texels(bytes);
  const std::size_t result = ZSTD_decompress(texels.data(), texels.size(), stored.data(), stored.size());
  if (ZSTD_isError(result) != 0 || result != bytes)
    refuse_texture(path, fmt::format("level {}, which Zstandard cannot decompress", level),
                   fmt::format("{} bytes", bytes));
  return texels;
}

void check_finite_texels(const LobeTexture& texture, const std::string& path) {
  if (texture.header.texels != LobeTexels::kRgba16f) return;
  for (const std::vector<std::uint8_t>& level : texture.levels)
    for (std::size_t i = 1; i < level.size(); i += 2)
      if ((level[i] & 0x7c) == 0x7c) refuse_texture(path, "a half float that is not finite", "finite values");
}

}  // namespace

bool is_ktx2_file(const std::string& path) { return first_bytes(path, kIdentifier.size()) == kIdentifier; }

LobeTextureHeader read_lobe_texture_header(const std::string& path) {
  ByteFile file(path);
  return read_texture_header(file, path);
}

LobeTexture read_lobe_texture(const std::string& path) {
  ByteFile file(path);
  LobeTexture texture{read_texture_header(file, path), {}};
  for (int l = 0; l < texture.header.level_count(); ++l)
    texture.levels.push_back(read_texture_level(file, texture.header, l, path));
  check_finite_texels(texture, path);
  return texture;
}

}  // namespace multum
