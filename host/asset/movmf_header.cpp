// SPDX-License-Identifier: Apache-2.0
#include "host/asset/movmf_header.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfIntAttribute.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include "host/asset/exr_compression.h"
#include "host/base/error.h"

namespace multum {
namespace {

constexpr int kVersion = 3;
constexpr char kRepresentation[] = "movmf";
constexpr int kSideMax = 1 << 20;

void set_text(Imf::Header& header, const char* name, const std::string& text) {
  header.insert(name, Imf::StringAttribute(text));
}

const char* channels_text(MovmfPartKind kind) {
  switch (kind) {
    case MovmfPartKind::kFinest:
      return "normalX, normalY = x, y; z = sqrt(max(0,1-x*x-y*y)), +X right, +Y up, +Z out; lobe = number of the "
             "lobe that has all of the texel; albedo = linear RGB; data, not colour";
    case MovmfPartKind::kLobe:
      return "R,G,B,A = a*r.x,a*r.y,a*r.z,a; r = mean normal, +X right, +Y up, +Z out; data, not colour";
    case MovmfPartKind::kColour: return "R,G,B = a*linear RGB of the lobe; a is in the lobe part of the same number";
  }
  return "";
}

Imath::Box2i window_of(const MovmfMipmap& header, int level) {
  const MovmfLevel& there = header.levels[static_cast<std::size_t>(level)];
  return {{0, 0}, {there.width - 1, there.height - 1}};
}

// The layout of pixels: windows, tiles, channels. OpenEXR wants one display window for all parts.
Imf::Header make_layout(const MovmfMipmap& mipmap, const MovmfPart& part, const MovmfWriteOptions& options) {
  const ExrCompression choice = parse_compression(options.compression);
  Imf::Header header(window_of(mipmap, mipmap.first_level), window_of(mipmap, part.first_level));
  header.setName(part.name);
  header.setType(Imf::TILEDIMAGE);
  header.compression() = choice.compression;
  if (choice.zip_level > 0) header.zipCompressionLevel() = choice.zip_level;
  header.lineOrder() = Imf::RANDOM_Y;  // tiles are written as they become ready: OpenEXR holds none back
  const auto tile = static_cast<unsigned>(options.tile_size);
  const auto levels = part.kind == MovmfPartKind::kFinest ? Imf::ONE_LEVEL : Imf::MIPMAP_LEVELS;
  header.setTileDescription(Imf::TileDescription(tile, tile, levels, Imf::ROUND_DOWN));
  for (const MovmfChannel& channel : part.channels) header.channels().insert(channel.name, Imf::Channel(channel.type));
  return header;
}

Imf::Header make_header(const MovmfMipmap& mipmap, const MovmfPart& part, const MovmfWriteOptions& options) {
  Imf::Header header = make_layout(mipmap, part, options);
  Imf::addWrapmodes(header, std::string(wrap_mode_name(mipmap.wrap_s)) + "," + wrap_mode_name(mipmap.wrap_t));
  const MovmfProvenance& from = mipmap.provenance;
  set_text(header, "software", from.software);
  set_text(header, "colorInteropID", "data");
  set_text(header, "multum:representation", kRepresentation);
  header.insert("multum:formatVersion", Imf::IntAttribute(kVersion));
  header.insert("multum:mapWidth", Imf::IntAttribute(mipmap.width()));
  header.insert("multum:mapHeight", Imf::IntAttribute(mipmap.height()));
  header.insert("multum:firstLevel", Imf::IntAttribute(mipmap.first_level));
  header.insert("multum:lobeCount", Imf::IntAttribute(mipmap.lobe_count()));
  header.insert("multum:hasColours", Imf::IntAttribute(mipmap.has_colours() ? 1 : 0));
  set_text(header, "multum:encoding", storage_encoding_name(mipmap.encoding));
  set_text(header, "multum:channels", channels_text(part.kind));
  header.insert("multum:kappaMax", Imf::FloatAttribute(storage_kappa_max(mipmap.encoding)));
  set_text(header, "multum:sourceName", from.source_name);
  set_text(header, "multum:sourceHash", from.source_hash);
  set_text(header, "multum:settings", from.settings);
  set_text(header, "multum:settingsHash", from.settings_hash);
  set_text(header, kContentHashAttribute, std::string(kContentHashDigits, ' '));
  return header;
}

[[noreturn]] void refuse(const std::string& path, const std::string& found, const std::string& expected) {
  throw Error(ErrorCode::kInput, path + ": found " + found + ", expected " + expected);
}

std::string text_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  if (attribute == nullptr)
    refuse(path, std::string("no attribute ") + name, "a file written by 'multum bake' (docs/FORMAT.md)");
  return attribute->value();
}

int int_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::IntAttribute>(name);
  if (attribute == nullptr)
    refuse(path, std::string("no attribute ") + name, "a file written by 'multum bake' (docs/FORMAT.md)");
  return attribute->value();
}

// Without the spaces that stand for room that was not needed.
std::string trimmed(const std::string& text) { return text.substr(0, text.find_last_not_of(' ') + 1); }

StorageEncoding parse_encoding(const std::string& name, const std::string& path) {
  for (StorageEncoding encoding : {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat})
    if (name == storage_encoding_name(encoding)) return encoding;
  refuse(path, "encoding '" + name + "'", "snorm16, half or float");
}

WrapMode parse_wrap(const std::string& name, const std::string& path) {
  const auto mode = parse_wrap_mode(name);
  if (!mode) refuse(path, "wrap mode '" + name + "'", "black, clamp, periodic or mirror");
  return *mode;
}

struct StoredLevels {
  int map_width, map_height;
  int first_level;
};

StoredLevels parse_stored_levels(const Imf::Header& header, const std::string& path) {
  const StoredLevels stored = {int_attribute(header, "multum:mapWidth", path),
                               int_attribute(header, "multum:mapHeight", path),
                               int_attribute(header, "multum:firstLevel", path)};
  const auto is_side = [](int side) { return side >= 1 && side <= kSideMax; };
  if (!is_side(stored.map_width) || !is_side(stored.map_height))
    refuse(path, fmt::format("a map of {} x {}", stored.map_width, stored.map_height),
           fmt::format("1 to {} texels a side", kSideMax));
  const int level_max = mip_level_count(stored.map_width, stored.map_height) - 1;
  if (stored.first_level < 0 || stored.first_level > level_max)
    refuse(path, fmt::format("first level {}", stored.first_level), fmt::format("0 to {}", level_max));
  return stored;
}

MovmfMipmap parse_header(const Imf::Header& header, const std::string& path) {
  const std::string representation = text_attribute(header, "multum:representation", path);
  if (representation != kRepresentation) refuse(path, "representation '" + representation + "'", "'movmf'");
  const int version = int_attribute(header, "multum:formatVersion", path);
  if (version != kVersion) refuse(path, fmt::format("format version {}", version), fmt::format("version {}", kVersion));
  const int lobe_count = int_attribute(header, "multum:lobeCount", path);
  if (lobe_count < 1 || lobe_count > kLobeCountMax)
    refuse(path, fmt::format("{} lobes", lobe_count), fmt::format("1 to {}", kLobeCountMax));
  const bool has_colours = int_attribute(header, "multum:hasColours", path) != 0;
  const StoredLevels stored = parse_stored_levels(header, path);

  MovmfMipmap mipmap;
  mipmap.first_level = stored.first_level;
  mipmap.encoding = parse_encoding(text_attribute(header, "multum:encoding", path), path);
  const std::string wraps = Imf::hasWrapmodes(header) ? Imf::wrapmodes(header) : "periodic";
  const std::size_t comma = wraps.find(',');
  mipmap.wrap_s = parse_wrap(wraps.substr(0, comma), path);
  mipmap.wrap_t = comma == std::string::npos ? mipmap.wrap_s : parse_wrap(wraps.substr(comma + 1), path);
  mipmap.provenance = {text_attribute(header, "software", path),
                       text_attribute(header, "multum:sourceName", path),
                       text_attribute(header, "multum:sourceHash", path),
                       text_attribute(header, "multum:settings", path),
                       text_attribute(header, "multum:settingsHash", path),
                       trimmed(text_attribute(header, kMeasuredErrorAttribute, path)),
                       trimmed(text_attribute(header, kContentHashAttribute, path))};
  for (int l = 0; l < mip_level_count(stored.map_width, stored.map_height); ++l) {
    MovmfLevel level;
    level.width = mip_level_size(stored.map_width, l);
    level.height = mip_level_size(stored.map_height, l);
    level.lobes.resize(static_cast<std::size_t>(lobe_count));
    if (has_colours) level.colours.resize(static_cast<std::size_t>(lobe_count));
    mipmap.levels.push_back(std::move(level));
  }
  return mipmap;
}

void check_tiles(const Imf::Header& header, const MovmfPart& part, const std::string& path) {
  const bool one_level = part.kind == MovmfPartKind::kFinest;
  const bool good = header.hasTileDescription() &&
                    header.tileDescription().mode == (one_level ? Imf::ONE_LEVEL : Imf::MIPMAP_LEVELS) &&
                    (one_level || header.tileDescription().roundingMode == Imf::ROUND_DOWN);
  if (good) return;
  const std::string expected = one_level ? "tiles of one level" : "ROUND_DOWN mip levels";
  refuse(path, "part " + part.name + " without " + expected, expected);
}

void check_channels(const Imf::Header& header, const MovmfPart& part, StorageEncoding encoding,
                    const std::string& path) {
  for (const MovmfChannel& expected : part.channels) {
    const Imf::Channel* channel = header.channels().findChannel(expected.name);
    if (channel == nullptr) refuse(path, "no channel " + expected.name + " in part " + part.name, "one");
    if (channel->type != expected.type || channel->xSampling != 1 || channel->ySampling != 1)
      refuse(path, "channel " + expected.name + " of another pixel type",
             std::string(expected.type == Imf::HALF ? "half" : "float") + " for encoding " +
                 storage_encoding_name(encoding));
  }
}

void check_part(const Imf::Header& header, int index, const MovmfPart& part, const MovmfMipmap& mipmap,
                const std::string& path) {
  if (!header.hasName() || header.name() != part.name)
    refuse(path, fmt::format("part {} named '{}'", index, header.hasName() ? header.name() : ""),
           "'" + part.name + "'");
  check_tiles(header, part, path);
  const Imath::Box2i found = header.dataWindow(), expected = window_of(mipmap, part.first_level);
  if (found != expected)
    refuse(path,
           fmt::format("part {} with a data window from ({}, {}) to ({}, {})", part.name, found.min.x, found.min.y,
                       found.max.x, found.max.y),
           fmt::format("(0, 0) to ({}, {}), level {} of a map of {} x {}", expected.max.x, expected.max.y,
                       part.first_level, mipmap.width(), mipmap.height()));
  check_channels(header, part, mipmap.encoding, path);
}

}  // namespace

std::vector<Imf::Header> make_headers(const MovmfMipmap& header, const std::vector<MovmfPart>& parts,
                                      const MovmfWriteOptions& options) {
  std::vector<Imf::Header> headers;
  for (const MovmfPart& part : parts) headers.push_back(make_header(header, part, options));
  const auto room = static_cast<std::size_t>(options.measured_error_bytes);
  set_text(headers[0], kMeasuredErrorAttribute, std::string(room, ' '));
  return headers;
}

MovmfMipmap parse_headers(const Imf::MultiPartInputFile& file, const std::string& path) {
  MovmfMipmap mipmap = parse_header(file.header(0), path);
  const std::vector<MovmfPart> parts = movmf_parts(mipmap);
  if (file.parts() != static_cast<int>(parts.size()))
    refuse(path, fmt::format("{} parts", file.parts()), fmt::format("{}", parts.size()));
  for (int i = 0; i < file.parts(); ++i)
    check_part(file.header(i), i, parts[static_cast<std::size_t>(i)], mipmap, path);
  return mipmap;
}

}  // namespace multum
