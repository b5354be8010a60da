// SPDX-License-Identifier: Apache-2.0
// The number of a UDIM tile is 1001 + u + 10 v, with u from 0 to 9 to the right and v upwards. Row 0 of an image is at
// the top, so tile 1011 ends where tile 1001 begins.
//
//   record  {"heights": {"coding": 0, "depth": 1, "sides": {"left": ["neighbour", TILE, SHA of its file, of its
//            border]}}, "green": {"axis": "down", "tiles": [[TILE, SHA of its file], ...]}}
#include "host/formats/image/normals/tile_set.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "host/formats/image/files/number_type.h"
#include "host/formats/image/image_reader.h"
#include "host/formats/image/normals/encoding_detection.h"
#include "host/formats/image/normals/image_survey.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/content_hash.h"
#include "host/foundation/base/files/udim_set.h"

namespace multum {
namespace {

using Json = nlohmann::json;
using Kind = TileBeside::Kind;

constexpr int kTilesPerRow = 10;

int number_of(const std::string& tile) { return std::stoi(tile) - 1001; }

// Tiles of one row or column, by their position.
struct TileLine {
  int own = 0;
  std::vector<int> places;  // sorted
  int step = 1;             // difference between tile numbers

  bool is_whole() const { return places.back() - places.front() + 1 == static_cast<int>(places.size()); }
  bool has(int place) const { return std::binary_search(places.begin(), places.end(), place); }
};

TileLine line_of(const std::vector<std::string>& tiles, const std::string& tile, bool is_row) {
  const int own = number_of(tile);
  TileLine line{is_row ? own % kTilesPerRow : own / kTilesPerRow, {}, is_row ? 1 : kTilesPerRow};
  for (const std::string& other : tiles) {
    const int number = number_of(other);
    const bool is_in_line =
        is_row ? number / kTilesPerRow == own / kTilesPerRow : number % kTilesPerRow == own % kTilesPerRow;
    if (is_in_line) line.places.push_back(is_row ? number % kTilesPerRow : number / kTilesPerRow);
  }
  std::sort(line.places.begin(), line.places.end());
  return line;
}

TileSide opposite(TileSide side) {
  switch (side) {
    case TileSide::kLeft: return TileSide::kRight;
    case TileSide::kRight: return TileSide::kLeft;
    case TileSide::kAbove: return TileSide::kBelow;
    case TileSide::kBelow: return TileSide::kAbove;
  }
  return side;
}

bool is_horizontal(TileSide side) { return side == TileSide::kLeft || side == TileSide::kRight; }
std::size_t index_of(TileSide side) { return static_cast<std::size_t>(side); }

HeightSide& side_of(HeightSides& sides, TileSide side) {
  switch (side) {
    case TileSide::kLeft: return sides.left;
    case TileSide::kRight: return sides.right;
    case TileSide::kAbove: return sides.above;
    case TileSide::kBelow: break;
  }
  return sides.below;
}

// Returns some columns, which are read in bands.
HeightRows columns_of(const HeightSurface& surface, int begin, int end) {
  constexpr int kRows = 64;
  HeightRows strip{begin, 0, end - begin, {}};
  for (int row = 0; row < surface.height(); row += kRows) {
    const int row_end = std::min(surface.height(), row + kRows);
    const HeightRows rows = surface.rows(row, row_end, 0);
    for (int r = row; r < row_end; ++r) strip.values.insert(strip.values.end(), rows.row(r) + begin, rows.row(r) + end);
  }
  return strip;
}

std::string hash_of(const HeightRows& strip) {
  std::string bytes = fmt::format("{} x {}\n", strip.row_width, strip.row_count());
  bytes.append(reinterpret_cast<const char*>(strip.values.data()), strip.values.size() * sizeof(float));
  return hash_text(bytes);
}

TileBorders read_borders(const std::string& path, const TileSet::BorderReading& reading, const SpillPolicy& spill) {
  ImageReader reader(path, {});
  const RawImageInfo info = reader.info();
  RawImage image(info, spill);
  ImageSurvey survey(info, {});
  reader.read(
      [&](const RawBand& band) {
        image.write(band);
        survey.add(band);
      },
      nullptr);
  TileBorders borders{info.width, info.height, info.base_type, "", {}, {}};
  const int channel_count = reading.coding == HeightCoding::kPacked16 ? 2 : 3;
  if (reading.coding == HeightCoding::kGrey ? !is_grey_image(info, survey) : info.channel_count < channel_count)
    borders.failure = fmt::format("does not contain heights of this kind ({})", info.format);
  if (!borders.failure.empty()) return borders;
  const HeightSurface surface(image, {reading.coding, survey.no_data()}, survey.nonfinite_count() == 0,
                              reading.fix_nan);
  const int columns = std::min(reading.depth, info.width), rows = std::min(reading.depth, info.height);
  const HeightRows strips[] = {columns_of(surface, 0, columns), columns_of(surface, info.width - columns, info.width),
                               surface.rows(0, rows, 0), surface.rows(info.height - rows, info.height, 0)};
  for (std::size_t i = 0; i < 4; ++i) {
    borders.hashes[i] = hash_of(strips[i]);
    borders.strips[i] = std::make_shared<const HeightRows>(strips[i]);
  }
  return borders;
}

// Moves a strip of another tile to its position next to this tile.
std::shared_ptr<const HeightRows> placed(const HeightRows& strip, TileSide side, const RawImageInfo& info) {
  HeightRows moved = strip;
  if (side == TileSide::kLeft) moved.column_begin = -strip.row_width;
  if (side == TileSide::kRight) moved.column_begin = info.width;
  if (side == TileSide::kAbove) moved.row_begin = -strip.row_count();
  if (side == TileSide::kBelow) moved.row_begin = info.height;
  return std::make_shared<const HeightRows>(std::move(moved));
}

bool is_unsigned_integer(int base_type) {
  return base_type == number_type::kUint8 || base_type == number_type::kUint16 || base_type == number_type::kUint32;
}

// Returns why two tiles do not form one surface, or an empty text if they do.
std::string difference(const TileBorders& other, const RawImageInfo& info) {
  if (!other.failure.empty()) return other.failure;
  if (other.width != info.width || other.height != info.height)
    return fmt::format("has {} x {} texels, expected {} x {}", other.width, other.height, info.width, info.height);
  const bool is_same = other.base_type == info.base_type ||
                       (is_unsigned_integer(other.base_type) && is_unsigned_integer(info.base_type));
  return is_same ? ""
                 : fmt::format("has numbers of type {}, expected {}", number_name(other.base_type),
                               number_name(info.base_type));
}

Json parse_record(const std::string& record) {
  Json json = Json::parse(record, nullptr, false);
  return json.is_object() ? json : Json::object();
}

std::string text_at(const Json& array, std::size_t i) {
  return array.is_array() && i < array.size() && array[i].is_string() ? array[i].get<std::string>() : "";
}

constexpr char kNeighbourWord[] = "neighbour", kEndWord[] = "other end", kUnlikeWord[] = "unlike", kNoneWord[] = "none";
constexpr char kUnaskedWord[] = "unasked";  // there is no neighbour, and the other end is not needed

// Returns the current state of a place, as a word of a record, and the tile at this place.
std::pair<std::string, std::string> place_now(const TileSet& set, const std::string& tile, TileSide side) {
  const TileBeside beside = set.beside(tile, side);
  if (beside.kind == Kind::kNeighbour) return {kNeighbourWord, beside.tile};
  if (beside.kind == Kind::kOtherEnd) return {kEndWord, beside.tile};
  return {kNoneWord, ""};
}

bool side_is_unchanged(const Json& entry, TileSet& set, const std::string& tile, TileSide side,
                       const TileSet::BorderReading& reading) {
  const auto [word, other] = place_now(set, tile, side);
  const std::string was = text_at(entry, 0);
  if (was == kUnaskedWord) return word != kNeighbourWord;
  if ((was == kUnlikeWord ? word == kNoneWord : was != word) || text_at(entry, 1) != other) return false;
  if (other.empty() || other == tile || set.file_hash(other) == text_at(entry, 2)) return true;
  if (was == kUnlikeWord) return false;
  const TileBorders& borders = set.borders(other, reading, {});
  return borders.failure.empty() && borders.hashes[index_of(opposite(side))] == text_at(entry, 3);
}

bool green_is_unchanged(const Json& green, TileSet& set) {
  const Json& tiles = green.at("tiles");
  if (tiles.empty() || tiles.size() > set.tiles().size()) return false;
  // If no tile has decided the direction of green, a tile that was added to the set may now decide it.
  if (green.at("axis") == "undecided" && tiles.size() < set.tiles().size()) return false;
  for (std::size_t i = 0; i < tiles.size(); ++i)
    if (text_at(tiles[i], 0) != set.tiles()[i] || text_at(tiles[i], 1) != set.file_hash(set.tiles()[i])) return false;
  return true;
}

bool heights_are_unchanged(const Json& heights, TileSet& set, const std::string& tile, FixNan fix_nan) {
  const int coding = heights.at("coding").get<int>(), depth = heights.at("depth").get<int>();
  if (coding < 0 || coding > static_cast<int>(HeightCoding::kMapbox) || depth < 1) return false;
  const TileSet::BorderReading reading{static_cast<HeightCoding>(coding), depth, fix_nan};
  return std::all_of(std::begin(kTileSides), std::end(kTileSides), [&](TileSide side) {
    return side_is_unchanged(heights.at("sides").at(tile_side_name(side)), set, tile, side, reading);
  });
}

}  // namespace

const char* tile_side_name(TileSide side) {
  switch (side) {
    case TileSide::kLeft: return "left";
    case TileSide::kRight: return "right";
    case TileSide::kAbove: return "above";
    case TileSide::kBelow: break;
  }
  return "below";
}

TileSet::TileSet(const std::string& pattern) : pattern_(pattern), tiles_(find_tiles(pattern)) {}

std::string TileSet::path(const std::string& tile) const { return with_tile(pattern_, tile); }

TileBeside TileSet::beside(const std::string& tile, TileSide side) const {
  const TileLine line = line_of(tiles_, tile, is_horizontal(side));
  const bool is_upwards = side == TileSide::kRight || side == TileSide::kAbove;
  const auto tile_at = [&](int place) {
    return std::to_string(1001 + number_of(tile) + (place - line.own) * line.step);
  };
  const int next = line.own + (is_upwards ? 1 : -1);
  if (line.has(next)) return {Kind::kNeighbour, tile_at(next)};
  const bool is_end = is_upwards ? line.own == line.places.back() : line.own == line.places.front();
  if (!is_end) return {Kind::kGap, tile_at(next)};
  if (!line.is_whole()) return {Kind::kBroken, ""};
  return {Kind::kOtherEnd, tile_at(is_upwards ? line.places.front() : line.places.back())};
}

const TileBorders& TileSet::borders(const std::string& tile, const BorderReading& reading, const SpillPolicy& spill) {
  const std::lock_guard lock(mutex_);
  const auto [found, is_new] = borders_.try_emplace({tile, reading});
  if (!is_new) return found->second;
  hashes_.note(path(tile));
  try {
    found->second = read_borders(path(tile), reading, spill);
    hashes_.check_unchanged(path(tile));
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& error) {
    found->second.failure = fmt::format("cannot be read ({})", error.what());
  }
  return found->second;
}

std::string TileSet::file_hash(const std::string& tile) { return hashes_.hash(path(tile)); }

TileSet::Green TileSet::green(const std::function<std::optional<GreenAxis>(const std::string& tile)>& of_tile) {
  const std::lock_guard lock(mutex_);
  Green green;
  for (const std::string& tile : tiles_) {
    const auto [found, is_new] = greens_.try_emplace(tile);
    if (is_new) {
      hashes_.note(path(tile));
      found->second = of_tile(tile);
    }
    green.asked.push_back(tile);
    green.axis = found->second;
    if (green.axis) break;
  }
  return green;
}

void TileSets::enter(const std::string& pattern, const std::string& tile, NormalMapSettings& settings) {
  if (pattern.empty()) return;
  std::shared_ptr<TileSet>& set = sets_[pattern];
  if (set == nullptr) set = std::make_shared<TileSet>(pattern);
  settings.tiles = set;
  settings.tile = tile;
}

TileSurroundings tile_surroundings(TileSet& set, const std::string& tile, const RawImageInfo& info,
                                   const TileRepeats& repeats, const TileSet::BorderReading& reading,
                                   const SpillPolicy& spill) {
  TileSurroundings around;
  Json sides = Json::object();
  for (const TileSide side : kTileSides) {
    const TileBeside beside = set.beside(tile, side);
    const char* const name = tile_side_name(side);
    const auto [word, other] = place_now(set, tile, side);
    sides[name] = {word, other};
    if (beside.kind == Kind::kGap)
      around.warnings.push_back(fmt::format(
          "its set has tiles beyond the missing tile {} ({}), so the surface ends at that border", beside.tile, name));
    if (word != kNeighbourWord && !(is_horizontal(side) ? repeats.s : repeats.t)) {
      sides[name] = {kUnaskedWord, ""};
      continue;
    }
    if (other.empty()) continue;
    if (other == tile) {
      side_of(around.repeated, side).beyond = HeightSide::Beyond::kWrapped;
      continue;
    }
    const TileBorders& borders = set.borders(other, reading, spill);
    if (const std::string why = difference(borders, info); !why.empty()) {
      around.warnings.push_back(fmt::format("tile {} ({}) {}, so the surface ends at that border", other, name, why));
      sides[name] = {kUnlikeWord, other, set.file_hash(other)};
      continue;
    }
    const std::size_t border = index_of(opposite(side));
    sides[name] = {word, other, set.file_hash(other), borders.hashes[border]};
    const bool is_neighbour = beside.kind == Kind::kNeighbour;
    side_of(is_neighbour ? around.neighbours : around.repeated, side) = {HeightSide::Beyond::kStrip,
                                                                         placed(*borders.strips[border], side, info)};
    if (!is_neighbour) continue;
    (is_horizontal(side) ? around.has_neighbour_s : around.has_neighbour_t) = true;
    around.text += fmt::format("{}{} ({})", around.text.empty() ? "continues in tile " : ", ", other, name);
  }
  around.record = Json{{"heights", {{"coding", reading.coding}, {"depth", reading.depth}, {"sides", sides}}}}.dump();
  return around;
}

std::string with_green(const std::string& record, TileSet& set, const TileSet::Green& green) {
  Json json = parse_record(record);
  Json tiles = Json::array();
  for (const std::string& tile : green.asked) tiles.push_back({tile, set.file_hash(tile)});
  json["green"] = {{"axis", green.axis ? choice_name(kGreenAxes, *green.axis) : "undecided"}, {"tiles", tiles}};
  return json.dump();
}

bool tiles_are_unchanged(const std::string& record, TileSet& set, const std::string& tile, FixNan fix_nan) {
  const Json json = parse_record(record);
  try {
    return (!json.contains("green") || green_is_unchanged(json["green"], set)) &&
           (!json.contains("heights") || heights_are_unchanged(json["heights"], set, tile, fix_nan));
  } catch (const Json::exception&) {  // the record lacks members
    return false;
  }
}

std::string tile_source_hash(const std::string& file_hash, const std::string& record) {
  const Json json = parse_record(record);
  std::string text = file_hash;
  if (json.contains("green") && json["green"].is_object())
    text += "\ngreen " + json["green"].value("axis", Json()).dump();
  if (json.contains("heights") && json["heights"].is_object() && json["heights"].contains("sides"))
    for (const auto& [side, entry] : json["heights"]["sides"].items())
      text += fmt::format("\n{} {} {} {}", side, text_at(entry, 0), text_at(entry, 1), text_at(entry, 3));
  return hash_text(text);
}

}  // namespace multum
