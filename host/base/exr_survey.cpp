// SPDX-License-Identifier: Apache-2.0
#include "host/base/exr_survey.h"

#include <algorithm>
#include <filesystem>
#include <map>

#include <fmt/format.h>

#include "host/base/error.h"

namespace multum {
namespace {

constexpr char kHeader[] = "an EXR header";

// A name or type of an EXR attribute, at most 255 bytes, with the position moved behind its zero byte.
std::string exr_string(const std::string& path, ByteFile& file, std::int64_t& position) {
  constexpr std::int64_t kBytesMax = 256;  // with the zero
  const std::int64_t left = std::max<std::int64_t>(0, file.size() - position);
  std::string text = file.bytes(position, std::min(left, kBytesMax), kHeader);
  const std::size_t size = text.find('\0');
  if (size == std::string::npos) {
    if (left < kBytesMax) file.bytes(position, left + 1, kHeader);  // which says that the file is cut
    refuse_file(path, "damaged EXR: a header name of more than 255 bytes");
  }
  text.resize(size);
  position += static_cast<std::int64_t>(size) + 1;
  for (char& byte : text)
    if (byte < ' ' || byte > '~') byte = '?';  // it may be shown in a message
  return text;
}

std::int64_t exr_int(ByteFile& file, std::int64_t position) {
  return static_cast<std::int32_t>(file.little_endian(position, 4, kHeader));
}

// The offset table holds 8 bytes for each chunk, and a chunk is a tile or at most 256 rows (DWAB): a size whose table
// does not fit into the file is false.
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

// Channels are [name 0][16 bytes], up to an empty name.
std::int64_t channel_list_size(const std::string& path, ByteFile& file, std::int64_t begin) {
  std::int64_t position = begin;
  while (!exr_string(path, file, position).empty()) position += 16;
  return position - begin;
}

// Texts are [length 4][bytes].
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

// What the library reads for a value goes by its type, not by the length that stands before it: where the two differ it
// takes a value's bytes for the next one's length.
void check_exr_value(const std::string& path, ByteFile& file, const std::string& name, const std::string& type,
                     std::int64_t position, std::int64_t size) {
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
    refuse_file(path, fmt::format("damaged EXR: attribute \"{}\" has {} bytes, expected {} of a {}", name, size,
                                  expected, type));
}

// One part's header: attributes of name, type, size 4, value; an empty name ends it.
bool inspect_exr_part(const std::string& path, ByteFile& file, ExrPartSize& part, std::int64_t& position) {
  std::int64_t tile_width = 0;
  std::int64_t tile_height = 0;
  for (int attribute_count = 0;; ++attribute_count) {
    const std::string name = exr_string(path, file, position);
    if (name.empty()) {
      if (attribute_count == 0) return false;
      break;
    }
    if (attribute_count > 4096) refuse_file(path, "damaged EXR: more than 4096 header attributes");
    const std::string type = exr_string(path, file, position);
    const std::int64_t size = exr_int(file, position);
    position += 4;
    if (size < 0 || size > file.size() - position)
      refuse_file(path, "damaged EXR: attribute \"" + name + "\" runs past the end");
    check_exr_value(path, file, name, type, position, size);
    if (name == "dataWindow" && size == 16) {
      part.width = exr_int(file, position + 8) - exr_int(file, position) + 1;
      part.height = exr_int(file, position + 12) - exr_int(file, position + 4) + 1;
    } else if (name == "tiles" && size == 9) {
      tile_width = exr_int(file, position);
      tile_height = exr_int(file, position + 4);
    }
    position += size;
  }
  if (part.width < 1 || part.height < 1)
    refuse_file(path, fmt::format("found a data window of {} x {}, expected at least 1 x 1", part.width, part.height));
  check_exr_table(path, file.size(), part, tile_width, tile_height);
  return true;
}

}  // namespace

std::vector<ExrPartSize> survey_exr(const std::string& path, ByteFile& file) {
  const std::int64_t version = file.little_endian(4, 4, "the EXR version");
  if ((version & 0x800) != 0) refuse_file(path, "found a deep EXR image, expected one value a texel");
  const bool is_multi_part = (version & 0x1000) != 0;
  constexpr std::size_t kPartCountMax = 256;
  std::int64_t position = 8;
  std::vector<ExrPartSize> parts;
  while (parts.size() < kPartCountMax) {
    ExrPartSize part;
    if (!inspect_exr_part(path, file, part, position)) break;
    parts.push_back(part);
    if (!is_multi_part) break;
  }
  if (parts.empty()) refuse_file(path, "damaged EXR: no header");
  return parts;
}

void check_exr_headers(const std::string& path, const std::string& otherwise) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return;
  try {
    ByteFile file(path);
    if (file.size() >= 8 && file.little_endian(0, 4, "the first bytes") == 0x01312f76) survey_exr(path, file);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::kInput) throw;
    const std::string words = error.what(), name = path + ": ";
    refuse_file(path, otherwise + ": " + (words.starts_with(name) ? words.substr(name.size()) : words));
  }
}

}  // namespace multum
