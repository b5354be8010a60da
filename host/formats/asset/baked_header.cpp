// SPDX-License-Identifier: Apache-2.0
#include "host/formats/asset/baked_header.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfIntAttribute.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <fmt/format.h>

#include "host/formats/asset/exr/exr_compression.h"
#include "host/formats/asset/exr/exr_rows.h"
#include "host/formats/asset/header_hash.h"
#include "host/formats/asset/row_checksums.h"
#include "host/foundation/base/error.h"

namespace multum {
namespace {

constexpr int kMapSideMax = 1 << 20;
constexpr char kReadingAttribute[] = "multum:reading";

void set_text(Imf::Header& header, const char* name, const std::string& text) {
  header.insert(name, Imf::StringAttribute(text));
}

Imath::Box2i window_of(const BakedHeader& header, int level) {
  return {{0, 0}, {mip_level_size(header.width, level) - 1, mip_level_size(header.height, level) - 1}};
}

// Makes the layout of the pixels, which consists of windows, tiles and channels. OpenEXR requires all parts to have the
// same display window.
Imf::Header make_layout(const BakedHeader& baked, const BakedPart& part, const BakedWriteOptions& options) {
  const ExrCompression choice = parse_compression(options.compression);
  Imf::Header header(window_of(baked, baked.first_level), window_of(baked, part.first_level));
  header.setName(part.name);
  header.setType(Imf::TILEDIMAGE);
  header.compression() = choice.compression;
  if (choice.zip_level > 0) header.zipCompressionLevel() = choice.zip_level;
  header.lineOrder() = Imf::RANDOM_Y;  // OpenEXR then writes tiles as soon as they are ready and keeps none in memory
  const auto tile = static_cast<unsigned>(options.tile_size);
  const auto levels = part.is_one_level ? Imf::ONE_LEVEL : Imf::MIPMAP_LEVELS;
  header.setTileDescription(Imf::TileDescription(tile, tile, levels, Imf::ROUND_DOWN));
  for (const BakedChannel& channel : part.channels) header.channels().insert(channel.name, Imf::Channel(channel.type));
  return header;
}

Imf::Header make_header(const BakedHeader& baked, const BakedPart& part, const BakedWriteOptions& options) {
  Imf::Header header = make_layout(baked, part, options);
  Imf::addWrapmodes(header, std::string(wrap_mode_name(baked.wrap_s)) + "," + wrap_mode_name(baked.wrap_t));
  const BakedProvenance& from = baked.provenance;
  const RepresentationInfo& info = representation_info(baked.representation);
  set_text(header, "software", from.software);
  set_text(header, "colorInteropID", "data");
  set_text(header, "multum:representation", info.name);
  header.insert("multum:formatVersion", Imf::IntAttribute(baked.format_version()));
  header.insert("multum:mapWidth", Imf::IntAttribute(baked.width));
  header.insert("multum:mapHeight", Imf::IntAttribute(baked.height));
  header.insert("multum:firstLevel", Imf::IntAttribute(baked.first_level));
  header.insert("multum:hasColours", Imf::IntAttribute(baked.has_colours ? 1 : 0));
  if (baked.format_version() > info.version) {  // otherwise, the bytes are the same as in files of older programs
    header.insert("multum:weightCount", Imf::IntAttribute(baked.weight_count));
    header.insert("multum:roughness", Imf::IntAttribute(baked.has_roughness ? 1 : 0));
    header.insert("multum:meanCosine", Imf::FloatAttribute(baked.mean_cosine));
  }
  set_text(header, "multum:encoding", storage_encoding_name(baked.encoding));
  set_text(header, "multum:channels", part.channels_text);
  set_text(header, "multum:sourceName", from.source_name);
  set_text(header, "multum:sourceHash", from.source_hash);
  if (!from.source_tiles.empty()) {
    set_text(header, "multum:sourceFileHash", from.source_file_hash);
    set_text(header, "multum:sourceTiles", from.source_tiles);
  }
  set_text(header, "multum:settings", from.settings);
  set_text(header, "multum:settingsHash", from.settings_hash);
  if (!from.reading.empty()) set_text(header, kReadingAttribute, from.reading);
  set_text(header, kContentHashAttribute, std::string(kContentHashDigits, ' '));
  return header;
}

// Removes the trailing spaces that fill the unused room.
std::string trimmed(const std::string& text) { return text.substr(0, text.find_last_not_of(' ') + 1); }

// Joins names into a list such as "snorm16, half or float".
std::string in_words(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t i = 0; i < names.size(); ++i)
    text += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  return text;
}

const RepresentationInfo& parse_representation(const std::string& name, const std::string& path) {
  std::vector<std::string> names;
  for (const RepresentationInfo& info : representations()) {
    if (name == info.name) return info;
    names.push_back(std::string("'") + info.name + "'");
  }
  refuse_file(path, "representation '" + name + "'", in_words(names));
}

StorageEncoding parse_encoding(const std::string& name, const std::vector<StorageEncoding>& encodings,
                               const std::string& path) {
  std::vector<std::string> names;
  for (const StorageEncoding encoding : encodings) {
    if (name == storage_encoding_name(encoding)) return encoding;
    names.emplace_back(storage_encoding_name(encoding));
  }
  refuse_file(path, "encoding '" + name + "'", in_words(names));
}

WrapMode parse_wrap(const std::string& name, const std::string& path) {
  const auto mode = parse_wrap_mode(name);
  if (!mode) refuse_file(path, "wrap mode '" + name + "'", "black, clamp, periodic or mirror");
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
  const auto is_side = [](int side) { return side >= 1 && side <= kMapSideMax; };
  if (!is_side(stored.map_width) || !is_side(stored.map_height))
    refuse_file(path, fmt::format("a map of {} x {}", stored.map_width, stored.map_height),
                fmt::format("1 to {} texels per side", kMapSideMax));
  const int level_max = mip_level_count(stored.map_width, stored.map_height) - 1;
  if (stored.first_level < 0 || stored.first_level > level_max)
    refuse_file(path, fmt::format("first level {}", stored.first_level), fmt::format("0 to {}", level_max));
  return stored;
}

void check_tiles(const Imf::Header& header, const BakedPart& part, const std::string& path) {
  const bool one_level = part.is_one_level;
  const bool good = header.hasTileDescription() &&
                    header.tileDescription().mode == (one_level ? Imf::ONE_LEVEL : Imf::MIPMAP_LEVELS) &&
                    (one_level || header.tileDescription().roundingMode == Imf::ROUND_DOWN);
  if (good) return;
  const std::string expected = one_level ? "tiles of one level" : "ROUND_DOWN mip levels";
  refuse_file(path, "part " + part.name + " without " + expected, expected);
}

void check_channels(const Imf::Header& header, const BakedPart& part, StorageEncoding encoding,
                    const std::string& path) {
  for (const BakedChannel& expected : part.channels) {
    const Imf::Channel* channel = header.channels().findChannel(expected.name);
    if (channel == nullptr) refuse_file(path, "no channel " + expected.name + " in part " + part.name, "one");
    if (channel->type != expected.type || channel->xSampling != 1 || channel->ySampling != 1)
      refuse_file(path, "channel " + expected.name + " of another pixel type",
                  std::string(expected.type == Imf::HALF ? "half" : "float") + " for encoding " +
                      storage_encoding_name(encoding));
  }
}

void check_part(const Imf::Header& header, int index, const BakedPart& part, const BakedHeader& baked,
                const std::string& path) {
  if (!header.hasName() || header.name() != part.name)
    refuse_file(path, fmt::format("part {} named '{}'", index, header.hasName() ? header.name() : ""),
                "'" + part.name + "'");
  check_tiles(header, part, path);
  const Imath::Box2i found = header.dataWindow(), expected = window_of(baked, part.first_level);
  if (found != expected)
    refuse_file(path,
                fmt::format("part {} with a data window from ({}, {}) to ({}, {})", part.name, found.min.x, found.min.y,
                            found.max.x, found.max.y),
                fmt::format("(0, 0) to ({}, {}), level {} of a map of {} x {}", expected.max.x, expected.max.y,
                            part.first_level, baked.width, baked.height));
  check_channels(header, part, baked.encoding, path);
}

float float_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::FloatAttribute>(name);
  if (attribute == nullptr)
    refuse_file(path, std::string("no attribute ") + name,
                "a file written by 'multum bake' (docs/reference/file_format.md)");
  return attribute->value();
}

// Reads the attributes of the newer format version.
void read_materials(const Imf::Header& header, const RepresentationInfo& info, const std::string& path,
                    BakedHeader& baked) {
  baked.weight_count = int_attribute(header, "multum:weightCount", path);
  baked.has_roughness = int_attribute(header, "multum:roughness", path) != 0;
  baked.mean_cosine = float_attribute(header, "multum:meanCosine", path);
  if (!(baked.mean_cosine >= 0.5f && baked.mean_cosine <= 1.0f))
    refuse_file(path, fmt::format("a mean cosine of {}", baked.mean_cosine), "0.5 to 1");
  if (baked.weight_count < 0 || baked.weight_count > kWeightCountMax)
    refuse_file(path, fmt::format("{} weights", baked.weight_count), fmt::format("0 to {}", kWeightCountMax));
  if (baked.weight_count == 0 && !baked.has_roughness)
    refuse_file(path, fmt::format("format version {} without weights and roughness", info.version + 1),
                fmt::format("version {}", info.version));
}

}  // namespace

void refuse_file(const std::string& path, const std::string& found, const std::string& expected) {
  throw Error(ErrorCode::kInput, path + ": found " + found + ", expected " + expected);
}

std::string text_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  if (attribute == nullptr)
    refuse_file(path, std::string("no attribute ") + name,
                "a file written by 'multum bake' (docs/reference/file_format.md)");
  return attribute->value();
}

int int_attribute(const Imf::Header& header, const char* name, const std::string& path) {
  const auto* attribute = header.findTypedAttribute<Imf::IntAttribute>(name);
  if (attribute == nullptr)
    refuse_file(path, std::string("no attribute ") + name,
                "a file written by 'multum bake' (docs/reference/file_format.md)");
  return attribute->value();
}

std::vector<Imf::Header> make_baked_headers(const BakedHeader& header, const std::vector<BakedPart>& parts,
                                            const BakedWriteOptions& options) {
  std::vector<Imf::Header> headers;
  for (const BakedPart& part : parts) headers.push_back(make_header(header, part, options));
  const auto room = static_cast<std::size_t>(options.measured_error_bytes);
  set_text(headers[0], kMeasuredErrorAttribute, std::string(room, ' '));
  set_text(headers[0], kRowChecksumsAttribute, RowChecksums(header, parts, options.tile_size).text());
  set_text(headers[0], kHeaderHashAttribute, std::string(kHeaderHashBytes, ' '));
  return headers;
}

// Reads an attribute that is only in files of tiles that belong to a set.
std::string optional_text(const Imf::Header& header, const char* name) {
  const auto* attribute = header.findTypedAttribute<Imf::StringAttribute>(name);
  return attribute == nullptr ? "" : attribute->value();
}

BakedHeader parse_map_header(const Imf::Header& header, const std::vector<StorageEncoding>& encodings,
                             const std::string& path) {
  const StoredLevels stored = parse_stored_levels(header, path);
  BakedHeader baked;
  baked.width = stored.map_width;
  baked.height = stored.map_height;
  baked.first_level = stored.first_level;
  baked.encoding = parse_encoding(text_attribute(header, "multum:encoding", path), encodings, path);
  const std::string wraps = Imf::hasWrapmodes(header) ? Imf::wrapmodes(header) : "periodic";
  const std::size_t comma = wraps.find(',');
  baked.wrap_s = parse_wrap(wraps.substr(0, comma), path);
  baked.wrap_t = comma == std::string::npos ? baked.wrap_s : parse_wrap(wraps.substr(comma + 1), path);
  baked.provenance = {text_attribute(header, "software", path),
                      text_attribute(header, "multum:sourceName", path),
                      text_attribute(header, "multum:sourceHash", path),
                      text_attribute(header, "multum:settings", path),
                      text_attribute(header, "multum:settingsHash", path),
                      trimmed(text_attribute(header, kMeasuredErrorAttribute, path)),
                      trimmed(text_attribute(header, kContentHashAttribute, path))};
  if (const auto* reading = header.findTypedAttribute<Imf::StringAttribute>(kReadingAttribute))
    baked.provenance.reading = reading->value();
  baked.provenance.source_file_hash = optional_text(header, "multum:sourceFileHash");
  baked.provenance.source_tiles = optional_text(header, "multum:sourceTiles");
  return baked;
}

BakedPart mean_colour_part(const BakedHeader& header) {
  BakedPart part{
      "colour", {}, header.first_level, header.level_count() - header.first_level, false, "R,G,B = mean linear RGB"};
  for (const char* name : {"colour.albedo.R", "colour.albedo.G", "colour.albedo.B"})
    part.channels.push_back({name, colour_type(header.encoding)});
  return part;
}

BakedPart mean_weights_part(const BakedHeader& header) {
  BakedPart part{"weights",
                 {},
                 header.first_level,
                 header.level_count() - header.first_level,
                 false,
                 "R,G,B,A = mean weights of basis BRDFs 0 to 3; data, not colour"};
  for (int k = 0; k < header.weight_count; ++k)
    part.channels.push_back({fmt::format("weights.blend.{}", "RGBA"[k]), colour_type(header.encoding)});
  return part;
}

BakedHeader parse_baked_header(const Imf::Header& header, const std::string& path) {
  const std::string name = text_attribute(header, "multum:representation", path);
  const RepresentationInfo& info = parse_representation(name, path);
  const int version = int_attribute(header, "multum:formatVersion", path);
  const int newest = info.version + 1;
  if (version != info.version && version != newest)
    refuse_file(path, fmt::format("format version {}", version), fmt::format("version {} or {}", info.version, newest));
  BakedHeader baked = parse_map_header(header, info.encodings, path);
  baked.representation = info.representation;
  baked.has_colours = int_attribute(header, "multum:hasColours", path) != 0;
  if (version > info.version) read_materials(header, info, path, baked);
  return baked;
}

BakedHeader parse_baked_header(const Imf::Header& header, Representation expected, const std::string& path) {
  const std::string name = text_attribute(header, "multum:representation", path);
  const std::string expected_name = representation_info(expected).name;
  if (name != expected_name) refuse_file(path, "representation '" + name + "'", "'" + expected_name + "'");
  return parse_baked_header(header, path);
}

void check_baked_parts(const Imf::MultiPartInputFile& file, const BakedHeader& header,
                       const std::vector<BakedPart>& parts, const std::string& path) {
  if (file.parts() != static_cast<int>(parts.size()))
    refuse_file(path, fmt::format("{} parts", file.parts()), fmt::format("{}", parts.size()));
  for (int i = 0; i < file.parts(); ++i)
    check_part(file.header(i), i, parts[static_cast<std::size_t>(i)], header, path);
}

}  // namespace multum
