// SPDX-License-Identifier: Apache-2.0
// Writing and reading of the baked file with OpenEXR: one tiled, mip-mapped part a lobe. docs/FORMAT.md describes the
// result for readers that do not use this code; both change together.
#include "host/asset/movmf_mipmap.h"

#include <ImfChannelList.h>
#include <ImfFloatAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <fmt/format.h>
#include <half.h>

#include <algorithm>
#include <map>

#include "host/base/atomic_file.h"
#include "host/base/content_hash.h"
#include "host/base/error.h"
#include "host/base/parallel.h"

namespace multum {
namespace {

// Files are written in the least version that describes them, so that older readers refuse only what they would take
// for something else.
constexpr int kVersionWhole = 1;   // every level is stored
constexpr int kVersionCoarse = 2;  // levels finer than multum:firstLevel are not: the parts begin there
constexpr char kRepresentation[] = "movmf";
constexpr int kSideMax = 1 << 20;

std::string lobe_channel(int lobe, const char* channel) { return fmt::format("lobe{}.vMF.{}", lobe, channel); }
std::string colour_channel(int lobe, const char* channel) { return fmt::format("colour{}.albedo.{}", lobe, channel); }

struct CompressionChoice {
  Imf::Compression compression;
  int zip_level;  // -1: the library's
};

CompressionChoice parse_compression(const std::string& text) {
  static const std::map<std::string, Imf::Compression> kNames = {{"none", Imf::NO_COMPRESSION},
                                                                 {"rle", Imf::RLE_COMPRESSION},
                                                                 {"zips", Imf::ZIPS_COMPRESSION},
                                                                 {"zip", Imf::ZIP_COMPRESSION},
                                                                 {"piz", Imf::PIZ_COMPRESSION}};
  const std::size_t colon = text.find(':');
  const auto found = kNames.find(text.substr(0, colon));
  int level = -1;
  if (colon != std::string::npos) {
    const std::string digits = text.substr(colon + 1);
    if (digits.size() == 1 && digits[0] >= '1' && digits[0] <= '9') level = digits[0] - '0';
  }
  const bool level_ok = colon == std::string::npos || (level > 0 && text.rfind("zip", 0) == 0);
  if (found == kNames.end() || !level_ok)
    throw Error(ErrorCode::kUsage,
                "compression '" + text +
                    "' is unknown; expected none, rle, zips, zip or piz (every one is lossless), and for "
                    "zip and zips an optional level such as zip:4");
  return {found->second, level};
}

// One part of the file: which channels, and where in a level their values lie. Lobe parts have four channels, colour
// parts three; `values` points at the first float of a level's first texel.
struct PartLayout {
  std::string name;
  std::vector<std::string> channels;
  int lobe;
  bool colour;

  const float* values(const MovmfLevel& level) const {
    const auto index = static_cast<std::size_t>(lobe);
    return colour ? &level.colours[index][0].x : &level.lobes[index][0].x;
  }
  float* values(MovmfLevel& level) const { return const_cast<float*>(values(static_cast<const MovmfLevel&>(level))); }
};

std::vector<PartLayout> part_layouts(int lobe_count, bool has_colours) {
  std::vector<PartLayout> parts;
  for (int j = 0; j < lobe_count; ++j)
    parts.push_back({fmt::format("lobe.{}", j),
                     {lobe_channel(j, "R"), lobe_channel(j, "G"), lobe_channel(j, "B"), lobe_channel(j, "A")},
                     j,
                     false});
  for (int j = 0; has_colours && j < lobe_count; ++j)
    parts.push_back({fmt::format("colour.{}", j),
                     {colour_channel(j, "R"), colour_channel(j, "G"), colour_channel(j, "B")},
                     j,
                     true});
  return parts;
}

// Half values go to HALF channels exactly (they were rounded before); everything else to FLOAT.
Imf::PixelType pixel_type(StorageEncoding encoding, bool colour) {
  const bool half_stored = encoding == StorageEncoding::kHalf || (colour && encoding == StorageEncoding::kSnorm16);
  return half_stored ? Imf::HALF : Imf::FLOAT;
}

void set_text(Imf::Header& header, const char* name, const std::string& text) {
  header.insert(name, Imf::StringAttribute(text));
}

Imf::Header make_header(const MovmfMipmap& mipmap, const PartLayout& part, const MovmfWriteOptions& options,
                        const std::string& content_hash) {
  const CompressionChoice choice = parse_compression(options.compression);
  const MovmfLevel& finest = mipmap.levels[static_cast<std::size_t>(mipmap.first_level)];
  Imf::Header header(finest.width, finest.height);
  header.setName(part.name);
  header.setType(Imf::TILEDIMAGE);
  header.compression() = choice.compression;
  if (choice.zip_level > 0) header.zipCompressionLevel() = choice.zip_level;
  header.lineOrder() = Imf::INCREASING_Y;
  const auto tile = static_cast<unsigned>(options.tile_size);
  header.setTileDescription(Imf::TileDescription(tile, tile, Imf::MIPMAP_LEVELS, Imf::ROUND_DOWN));
  for (const std::string& channel : part.channels)
    header.channels().insert(channel, Imf::Channel(pixel_type(mipmap.encoding, part.colour)));
  Imf::addWrapmodes(header, std::string(wrap_mode_name(mipmap.wrap_s)) + "," + wrap_mode_name(mipmap.wrap_t));
  const MovmfProvenance& from = mipmap.provenance;
  set_text(header, "software", from.software);
  set_text(header, "colorInteropID", "data");
  set_text(header, "multum:representation", kRepresentation);
  header.insert("multum:formatVersion", Imf::IntAttribute(mipmap.first_level > 0 ? kVersionCoarse : kVersionWhole));
  header.insert("multum:mapWidth", Imf::IntAttribute(mipmap.width()));
  header.insert("multum:mapHeight", Imf::IntAttribute(mipmap.height()));
  header.insert("multum:firstLevel", Imf::IntAttribute(mipmap.first_level));
  header.insert("multum:lobeCount", Imf::IntAttribute(mipmap.lobe_count()));
  header.insert("multum:hasColours", Imf::IntAttribute(mipmap.has_colours() ? 1 : 0));
  set_text(header, "multum:encoding", storage_encoding_name(mipmap.encoding));
  set_text(header, "multum:channels",
           part.colour ? "R,G,B = a*linear RGB of the lobe; a is in the lobe part of the same number"
                       : "R,G,B,A = a*r.x,a*r.y,a*r.z,a; r = mean normal, +X right, +Y up, +Z out; data, not colour");
  header.insert("multum:kappaMax", Imf::FloatAttribute(storage_kappa_max(mipmap.encoding)));
  set_text(header, "multum:sourceName", from.source_name);
  set_text(header, "multum:sourceHash", from.source_hash);
  set_text(header, "multum:settings", from.settings);
  set_text(header, "multum:settingsHash", from.settings_hash);
  set_text(header, "multum:measuredError", from.measured_error);
  set_text(header, "multum:contentHash", content_hash);
  return header;
}

// Slices of one level: floats interleaved `channel_count` to a texel, or the same as halfs in `halfs`.
template <typename Value>
Imf::FrameBuffer frame_buffer(const PartLayout& part, Value* values, int width, Imf::PixelType type) {
  Imf::FrameBuffer buffer;
  const std::size_t stride = sizeof(Value) * part.channels.size();
  for (std::size_t c = 0; c < part.channels.size(); ++c)
    buffer.insert(part.channels[c], Imf::Slice(type, const_cast<char*>(reinterpret_cast<const char*>(values + c)),
                                               stride, stride * static_cast<std::size_t>(width)));
  return buffer;
}

std::size_t value_count(const MovmfLevel& level, const PartLayout& part) {
  return static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height) * part.channels.size();
}

void write_part(Imf::MultiPartOutputFile& file, int part_index, const PartLayout& part, const MovmfMipmap& mipmap,
                Progress* progress) {
  Imf::TiledOutputPart out(file, part_index);
  const Imf::PixelType type = pixel_type(mipmap.encoding, part.colour);
  std::vector<half> halfs;
  for (int l = 0; l < out.numLevels(); ++l) {
    const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(mipmap.first_level + l)];
    const float* values = part.values(level);
    if (type == Imf::HALF) {
      halfs.resize(value_count(level, part));
      std::transform(values, values + halfs.size(), halfs.begin(), [](float v) { return half(v); });
      out.setFrameBuffer(frame_buffer(part, halfs.data(), level.width, type));
    } else {
      out.setFrameBuffer(frame_buffer(part, values, level.width, type));
    }
    for (int tile_row = 0; tile_row < out.numYTiles(l); ++tile_row) {
      progress_advance(progress, 0);  // a chance to cancel
      out.writeTiles(0, out.numXTiles(l) - 1, tile_row, tile_row, l);
    }
  }
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
  int first_level;  // its size is the data window's
};

StoredLevels parse_stored_levels(const Imf::Header& header, int version, const std::string& path) {
  const Imath::Box2i window = header.dataWindow();
  const std::int64_t width = std::int64_t{window.max.x} - window.min.x + 1;
  const std::int64_t height = std::int64_t{window.max.y} - window.min.y + 1;
  if (window.min.x != 0 || window.min.y != 0 || width < 1 || height < 1 || width > kSideMax || height > kSideMax)
    refuse(path, fmt::format("a data window of {} x {} at ({}, {})", width, height, window.min.x, window.min.y),
           fmt::format("a map of 1 to {} texels a side at (0, 0)", kSideMax));
  if (version == kVersionWhole) return {static_cast<int>(width), static_cast<int>(height), 0};
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
  const int level_width = mip_level_size(stored.map_width, stored.first_level);
  const int level_height = mip_level_size(stored.map_height, stored.first_level);
  if (width != level_width || height != level_height)
    refuse(path, fmt::format("a data window of {} x {}", width, height),
           fmt::format("{} x {}, level {} of a map of {} x {}", level_width, level_height, stored.first_level,
                       stored.map_width, stored.map_height));
  return stored;
}

// Everything but pixels, from the first part's header.
MovmfMipmap parse_header(const Imf::MultiPartInputFile& file, const std::string& path) {
  const Imf::Header& header = file.header(0);
  const std::string representation = text_attribute(header, "multum:representation", path);
  if (representation != kRepresentation) refuse(path, "representation '" + representation + "'", "'movmf'");
  const int version = int_attribute(header, "multum:formatVersion", path);
  if (version != kVersionWhole && version != kVersionCoarse)
    refuse(path, fmt::format("format version {}", version),
           fmt::format("version {} or {}", kVersionWhole, kVersionCoarse));
  const int lobe_count = int_attribute(header, "multum:lobeCount", path);
  if (lobe_count < 1 || lobe_count > kLobeCountMax)
    refuse(path, fmt::format("{} lobes", lobe_count), fmt::format("1 to {}", kLobeCountMax));
  const bool has_colours = int_attribute(header, "multum:hasColours", path) != 0;
  const StoredLevels stored = parse_stored_levels(header, version, path);

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
                       text_attribute(header, "multum:measuredError", path),
                       text_attribute(header, "multum:contentHash", path)};
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

void check_part(const Imf::MultiPartInputFile& file, int index, const PartLayout& part, const MovmfMipmap& mipmap,
                const std::string& path) {
  const Imf::Header& header = file.header(index);
  if (!header.hasName() || header.name() != part.name)
    refuse(path, fmt::format("part {} named '{}'", index, header.hasName() ? header.name() : ""),
           "'" + part.name + "'");
  if (!header.hasTileDescription() || header.tileDescription().mode != Imf::MIPMAP_LEVELS ||
      header.tileDescription().roundingMode != Imf::ROUND_DOWN)
    refuse(path, "part " + part.name + " without ROUND_DOWN mip levels", "tiles with ROUND_DOWN mip levels");
  if (header.dataWindow() != file.header(0).dataWindow())
    refuse(path, "part " + part.name + " of another size than the first part", "parts of one size");
  const Imf::PixelType type = pixel_type(mipmap.encoding, part.colour);
  for (const std::string& name : part.channels) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    if (channel == nullptr) refuse(path, "no channel " + name + " in part " + part.name, "one");
    if (channel->type != type || channel->xSampling != 1 || channel->ySampling != 1)
      refuse(path, "channel " + name + " of another pixel type",
             std::string(type == Imf::HALF ? "half" : "float") + " for encoding " +
                 storage_encoding_name(mipmap.encoding));
  }
}

void read_part(Imf::MultiPartInputFile& file, int part_index, const PartLayout& part, MovmfMipmap& mipmap) {
  Imf::TiledInputPart in(file, part_index);
  for (int l = 0; l < in.numLevels(); ++l) {
    MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(mipmap.first_level + l)];
    const std::size_t texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
    const auto lobe = static_cast<std::size_t>(part.lobe);
    if (part.colour) level.colours[lobe].resize(texels);
    else level.lobes[lobe].resize(texels);
    in.setFrameBuffer(frame_buffer(part, part.values(level), level.width, Imf::FLOAT));
    in.readTiles(0, in.numXTiles(l) - 1, 0, in.numYTiles(l) - 1, l);
  }
}

// Opens the file and checks its structure; calls `body(file, mipmap, parts)`. Library exceptions become Errors.
template <typename Body>
MovmfMipmap open_checked(const std::string& path, const Body& body) {
  try {
    Imf::MultiPartInputFile file(path.c_str());
    MovmfMipmap mipmap = parse_header(file, path);
    const std::vector<PartLayout> parts = part_layouts(mipmap.lobe_count(), mipmap.has_colours());
    if (file.parts() != static_cast<int>(parts.size()))
      refuse(path, fmt::format("{} parts", file.parts()), fmt::format("{}", parts.size()));
    for (int i = 0; i < file.parts(); ++i) check_part(file, i, parts[static_cast<std::size_t>(i)], mipmap, path);
    body(file, mipmap, parts);
    return mipmap;
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kInput, path + ": not a readable baked file: " + error.what());
  }
}

}  // namespace

const char* storage_encoding_name(StorageEncoding encoding) {
  switch (encoding) {
    case StorageEncoding::kSnorm16: return "snorm16";
    case StorageEncoding::kHalf: return "half";
    case StorageEncoding::kFloat: return "float";
  }
  return "?";
}

int mip_level_count(int width, int height) {
  int count = 1;
  for (int side = std::max(width, height); side > 1; side >>= 1) ++count;
  return count;
}

std::string levels_text(const MovmfMipmap& mipmap) {
  const std::size_t count = mipmap.levels.size();
  if (mipmap.first_level == 0) return fmt::format("{} levels", count);
  const int coarsest = static_cast<int>(count) - 1;
  if (mipmap.first_level == coarsest) return fmt::format("level {} of 0 to {}", coarsest, coarsest);
  return fmt::format("levels {} to {} of 0 to {}", mipmap.first_level, coarsest, coarsest);
}

void drop_finer_levels(MovmfMipmap& mipmap, int first_level) {
  MULTUM_CHECK(first_level >= mipmap.first_level && first_level < static_cast<int>(mipmap.levels.size()));
  for (int l = 0; l < first_level; ++l) {
    MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    for (auto& lobe : level.lobes) lobe = std::vector<glm::vec4>();  // = {} would keep the memory
    for (auto& colour : level.colours) colour = std::vector<glm::vec3>();
  }
  mipmap.first_level = first_level;
}

std::string movmf_content_hash(const MovmfMipmap& mipmap, int threads) {
  const std::vector<PartLayout> parts = part_layouts(mipmap.lobe_count(), mipmap.has_colours());
  const auto first_level = static_cast<std::size_t>(mipmap.first_level);
  const std::size_t level_count = mipmap.levels.size() - first_level;
  std::vector<std::string> digests(parts.size() * level_count);
  for_each_item(static_cast<int>(digests.size()), threads, [&](int item) {
    const auto i = static_cast<std::size_t>(item);
    const PartLayout& part = parts[i / level_count];
    const MovmfLevel& level = mipmap.levels[first_level + i % level_count];
    ContentHash hash;
    hash.update(part.values(level), value_count(level, part) * sizeof(float));
    digests[i] = hash.finish();
  });
  ContentHash all;
  for (const std::string& digest : digests) all.update(digest);
  return all.finish();
}

void validate(const MovmfWriteOptions& options) { parse_compression(options.compression); }

void write_movmf_mipmap(const std::string& path, const MovmfMipmap& mipmap, const MovmfWriteOptions& options,
                        Progress* progress) {
  MULTUM_CHECK(mipmap.lobe_count() >= 1 && mipmap.lobe_count() <= kLobeCountMax);
  const int level_count = static_cast<int>(mipmap.levels.size());
  MULTUM_CHECK(level_count == mip_level_count(mipmap.width(), mipmap.height()));
  MULTUM_CHECK(mipmap.first_level >= 0 && mipmap.first_level < level_count);
  const std::vector<PartLayout> parts = part_layouts(mipmap.lobe_count(), mipmap.has_colours());
  const std::string content_hash = movmf_content_hash(mipmap, options.threads);
  std::vector<Imf::Header> headers;
  for (const PartLayout& part : parts) headers.push_back(make_header(mipmap, part, options, content_hash));
  Imf::setGlobalThreadCount(options.threads);
  AtomicFile file(path);
  try {
    Imf::MultiPartOutputFile out(file.temporary_path().c_str(), headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < parts.size(); ++i) write_part(out, static_cast<int>(i), parts[i], mipmap, progress);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const Cancelled&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(ErrorCode::kEnvironment, path + ": writing failed: " + error.what());
  }
  progress_advance(progress, 0);  // the last chance
  file.commit();
}

MovmfMipmap read_movmf_mipmap(const std::string& path) {
  const auto read_parts = [](Imf::MultiPartInputFile& file, MovmfMipmap& mipmap, const std::vector<PartLayout>& parts) {
    for (std::size_t i = 0; i < parts.size(); ++i) read_part(file, static_cast<int>(i), parts[i], mipmap);
  };
  return open_checked(path, read_parts);
}

MovmfMipmap read_movmf_header(const std::string& path) {
  return open_checked(path, [](Imf::MultiPartInputFile&, MovmfMipmap&, const std::vector<PartLayout>&) {});
}

}  // namespace multum
