// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/exr_survey.h"

#include <algorithm>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/regular_file.h"

namespace multum {
namespace {

constexpr char kHeader[] = "an EXR header";
constexpr std::uint64_t kExrMagic = 0x01312f76;  // the first four bytes

// Reads the name or type of an EXR attribute, which has at most 255 bytes, and moves `position` past its zero byte.
std::string exr_string(const std::string& path, ByteFile& file, std::int64_t& position) {
  constexpr std::int64_t kBytesMax = 256;  // includes the zero byte
  const std::int64_t left = std::max<std::int64_t>(0, file.size() - position);
  std::string text = file.bytes(position, std::min(left, kBytesMax), kHeader);
  const std::size_t size = text.find('\0');
  if (size == std::string::npos) {
    if (left < kBytesMax) file.bytes(position, left + 1, kHeader);  // throws, because the file is cut
    refuse_file(path, "damaged EXR: a header name of more than 255 bytes");
  }
  text.resize(size);
  position += static_cast<std::int64_t>(size) + 1;
  return text;
}

// Replaces the characters that a message must not contain.
std::string plain(std::string text) {
  for (char& byte : text)
    if (byte < ' ' || byte > '~') byte = '?';
  return text;
}

std::int64_t exr_int(ByteFile& file, std::int64_t position) {
  return static_cast<std::int32_t>(file.little_endian(position, 4, kHeader));
}

// The offset table holds 8 bytes per chunk. A chunk is a tile, or a block of at most 256 rows (DWAB). If the file is
// smaller than the table that an image size requires, the size is wrong.
void check_exr_table(const std::string& path, std::int64_t file_size, const ExrPartSize& part, std::int64_t tile_width,
                     std::int64_t tile_height) {
  std::int64_t chunk_count = (part.height + 255) / 256;
  if (tile_width != 0 || tile_height != 0) {
    if (tile_width < 1 || tile_height < 1 || tile_width > 65536 || tile_height > 65536 ||
        tile_width * tile_height > (1 << 26))
      refuse_file(path, fmt::format("found tiles of {} x {}, expected at most 2^26 texels", tile_width, tile_height));
    chunk_count = ((part.width + tile_width - 1) / tile_width) * ((part.height + tile_height - 1) / tile_height);
  }
  if (chunk_count * 8 > file_size)
    refuse_file(path, fmt::format("declares {} x {} texels, which a file of {} bytes cannot hold", part.width,
                                  part.height, file_size));
}

// Returns the first channel that has fewer samples than texels. A channel is [name 0][type 4][flags 4][steps in x 4, in
// y 4].
std::string subsampled_channel(const std::string& path, ByteFile& file, std::int64_t position) {
  for (;; position += 16) {
    std::string name = exr_string(path, file, position);
    if (name.empty() || exr_int(file, position + 8) > 1 || exr_int(file, position + 12) > 1) return plain(name);
  }
}

// Each channel is [name 0][16 bytes]. An empty name ends the list.
std::int64_t channel_list_size(const std::string& path, ByteFile& file, std::int64_t begin) {
  std::int64_t position = begin;
  while (!exr_string(path, file, position).empty()) position += 16;
  return position - begin;
}

// Each text is [length 4][bytes].
std::int64_t text_list_size(ByteFile& file, std::int64_t begin, std::int64_t size) {
  std::int64_t position = begin;
  while (position < begin + size) {
    const std::int64_t length = exr_int(file, position);
    if (length < 0) return -1;
    position += 4 + length;
  }
  return position - begin;
}

// A preview is [width 4][height 4][RGBA of 8 bits].
std::int64_t preview_size(ByteFile& file, std::int64_t begin) {
  constexpr std::int64_t kSideMax = 65535;
  const std::int64_t width = exr_int(file, begin), height = exr_int(file, begin + 4);
  return width < 0 || height < 0 || width > kSideMax || height > kSideMax ? -1 : 8 + 4 * width * height;
}

// The library reads a value according to its type and ignores the length stored before the value. If the two lengths
// differ, the library reads bytes of the value as the length of the next attribute.
void check_exr_value(const std::string& path, ByteFile& file, const ExrAttribute& attribute) {
  const auto& [part, name, type, position, size] = attribute;
  static const std::map<std::string, std::int64_t> kSizes = {{"box2i", 16},      {"box2f", 16}, {"chromaticities", 32},
                                                             {"compression", 1}, {"double", 8}, {"envmap", 1},
                                                             {"float", 4},       {"int", 4},    {"keycode", 28},
                                                             {"lineOrder", 1},   {"m33f", 36},  {"m33d", 72},
                                                             {"m44f", 64},       {"m44d", 128}, {"rational", 8},
                                                             {"tiledesc", 9},    {"v2i", 8},    {"v2f", 8},
                                                             {"timecode", 8},    {"v2d", 16},   {"v3i", 12},
                                                             {"v3f", 12},        {"v3d", 24},   {"deepImageState", 1}};
  std::int64_t expected = size;
  if (const auto found = kSizes.find(type); found != kSizes.end()) expected = found->second;
  else if (type == "chlist") expected = channel_list_size(path, file, position);
  else if (type == "preview") expected = preview_size(file, position);
  else if (type == "stringvector") expected = text_list_size(file, position, size);
  if (size != expected)
    refuse_file(path, fmt::format("damaged EXR: attribute \"{}\" has {} bytes, expected {} for type {}", plain(name),
                                  size, expected, plain(type)));
}

// Reads the header of one part. Each attribute in it has a name, a type, a size (4 bytes) and a value. An empty name
// ends the header. Returns false if the part has no attributes.
bool walk_part(const std::string& path, ByteFile& file, int part, std::int64_t& position,
               const std::function<void(const ExrAttribute&)>& visit) {
  for (int attribute_count = 0;; ++attribute_count) {
    ExrAttribute attribute = {part, exr_string(path, file, position), "", 0, 0};
    if (attribute.name.empty()) return attribute_count > 0;
    if (attribute_count > 4096) refuse_file(path, "damaged EXR: more than 4096 header attributes");
    attribute.type = exr_string(path, file, position);
    attribute.size = exr_int(file, position);
    attribute.position = position + 4;
    if (attribute.size < 0 || attribute.size > file.size() - attribute.position)
      refuse_file(path, "damaged EXR: attribute \"" + plain(attribute.name) + "\" runs past the end");
    visit(attribute);
    position = attribute.position + attribute.size;
  }
}

}  // namespace

void walk_exr_headers(const std::string& path, ByteFile& file, const std::function<void(const ExrAttribute&)>& visit,
                      const std::function<void()>& end_part) {
  constexpr int kPartCountMax = 256;
  const bool is_multi_part = (file.little_endian(4, 4, "the EXR version") & 0x1000) != 0;
  std::int64_t position = 8;
  for (int part = 0; part < kPartCountMax && walk_part(path, file, part, position, visit); ++part) {
    if (end_part) end_part();
    if (!is_multi_part) break;
  }
}

std::vector<ExrPartSize> survey_exr(const std::string& path, ByteFile& file) {
  if ((file.little_endian(4, 4, "the EXR version") & 0x800) != 0)
    refuse_file(path, "found a deep EXR image, expected one value per texel");
  std::vector<ExrPartSize> parts;
  ExrPartSize part;
  std::int64_t tile_width = 0, tile_height = 0;
  const auto visit = [&](const ExrAttribute& attribute) {
    check_exr_value(path, file, attribute);
    const std::int64_t at = attribute.position;
    if (attribute.name == "dataWindow" && attribute.size == 16) {
      part.width = exr_int(file, at + 8) - exr_int(file, at) + 1;
      part.height = exr_int(file, at + 12) - exr_int(file, at + 4) + 1;
    } else if (attribute.name == "channels" && attribute.type == "chlist") {
      part.subsampled = subsampled_channel(path, file, at);
    } else if (attribute.name == "tiles" && attribute.size == 9) {
      tile_width = exr_int(file, at);
      tile_height = exr_int(file, at + 4);
    }
  };
  const auto end_part = [&] {
    if (part.width < 1 || part.height < 1)
      refuse_file(path,
                  fmt::format("found a data window of {} x {}, expected at least 1 x 1", part.width, part.height));
    check_exr_table(path, file.size(), part, tile_width, tile_height);
    parts.push_back(std::exchange(part, {}));
    tile_width = tile_height = 0;
  };
  walk_exr_headers(path, file, visit, end_part);
  if (parts.empty()) refuse_file(path, "damaged EXR: no header");
  return parts;
}

void check_exr_headers(const std::string& path, const std::string& otherwise) {
  try {
    OpenFile opened = open_regular_file(path);
    if (!opened.is_open()) return;
    ByteFile file(std::move(opened), path);
    if (file.size() < 4 || file.little_endian(0, 4, "the first bytes") != kExrMagic)
      refuse_file(path, "not an OpenEXR file, expected one that multum wrote");
    if (file.size() >= 8) survey_exr(path, file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInput) throw;
    const std::string words = error.what(), name = path + ": ";
    refuse_file(path, otherwise + ": " + (words.starts_with(name) ? words.substr(name.size()) : words));
  }
}

}  // namespace multum
