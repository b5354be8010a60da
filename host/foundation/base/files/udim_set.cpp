// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/files/udim_set.h"

#include <algorithm>
#include <filesystem>
#include <optional>
#include <string_view>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/output_paths.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

// Placeholders for tile numbers, and for the pair of u and v.
constexpr std::string_view kNumberWords[] = {"<UDIM>", "<udim>", "%(UDIM)d"};
constexpr std::string_view kPairWords[] = {"<UVTILE>", "<uvtile>"};
constexpr std::size_t kTileDigits = 4;
constexpr int kFirstTile = 1001, kTilesPerRow = 10, kLastTile = 9999;

bool is_digits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

// The first placeholder in a path.
struct TileWord {
  std::size_t at = std::string::npos, length = 0;
  bool is_pair = false;
};

TileWord find_word(std::string_view path) {
  TileWord first;
  const auto look_for = [&](std::string_view word, bool is_pair) {
    if (const std::size_t at = path.find(word); at < first.at) first = {at, word.size(), is_pair};
  };
  for (const std::string_view word : kNumberWords) look_for(word, false);
  for (const std::string_view word : kPairWords) look_for(word, true);
  return first;
}

std::string pair_text(const std::string& tile) {
  const int number = std::stoi(tile) - kFirstTile;
  return "u" + std::to_string(number % kTilesPerRow + 1) + "_v" + std::to_string(number / kTilesPerRow + 1);
}

// Returns the number at the beginning of a name. The number ends before the first character that is not a digit.
// Returns nullopt if there is no number.
std::optional<int> leading_number(std::string_view& name) {
  std::size_t length = 0;
  while (length < name.size() && length < kTileDigits && is_digits(name.substr(length, 1))) ++length;
  if (length == 0) return std::nullopt;
  const int number = std::stoi(std::string(name.substr(0, length)));
  name.remove_prefix(length);
  return number;
}

// Returns the tile at the beginning of a name as a number, or nullopt if there is none.
std::string leading_tile(std::string_view name, bool is_pair) {
  if (!is_pair) {
    const std::string tile(name.substr(0, kTileDigits));
    return tile.size() == kTileDigits && is_digits(tile) && std::stoi(tile) >= kFirstTile ? tile : "";
  }
  if (!name.starts_with("u")) return "";
  name.remove_prefix(1);
  const std::optional<int> u = leading_number(name);
  if (!u || !name.starts_with("_v")) return "";
  name.remove_prefix(2);
  const std::optional<int> v = leading_number(name);
  if (!v || *u < 1 || *u > kTilesPerRow || *v < 1) return "";
  const int tile = kFirstTile + (*u - 1) + kTilesPerRow * (*v - 1);
  return tile <= kLastTile ? std::to_string(tile) : "";
}

}  // namespace

bool has_udim(const std::string& path) { return find_word(path).at != std::string::npos; }

std::string with_tile(std::string path, const std::string& tile) {
  for (TileWord word = find_word(path); word.at != std::string::npos; word = find_word(path))
    path.replace(word.at, word.length, word.is_pair ? pair_text(tile) : tile);
  return path;
}

std::vector<std::string> find_tiles(const std::string& set) {
  const fs::path path(set);
  const std::string name = path.filename().string();
  const TileWord word = find_word(name);
  if (word.at == std::string::npos)
    throw Error(ErrorCode::kUsage, set + ": found <UDIM> in the name of a folder, expected it in the file name");
  std::vector<std::string> tiles;
  std::error_code none;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(path.has_parent_path() ? path.parent_path() : fs::path("."), none)) {
    const std::string found = entry.path().filename().string();
    if (found.size() < word.at) continue;
    const std::string tile = leading_tile(std::string_view(found).substr(word.at), word.is_pair);
    if (!tile.empty() && found == with_tile(name, tile)) tiles.push_back(tile);
  }
  std::sort(tiles.begin(), tiles.end());
  return tiles;
}

std::vector<SetMap> maps_of_names(const std::vector<std::string>& inputs) {
  std::vector<SetMap> maps;
  for (const std::string& input : inputs) {
    if (!has_udim(input)) {
      maps.push_back({input, ""});
      continue;
    }
    const std::vector<std::string> tiles = find_tiles(input);
    if (tiles.empty())
      throw Error(ErrorCode::kInput,
                  input + ": found no file of this set, expected " + with_tile(input, "1001") + " or others");
    for (const std::string& tile : tiles) maps.push_back({with_tile(input, tile), tile, tiles.size() > 1 ? input : ""});
  }
  return maps;
}

std::string place_of_map(const std::string& pattern, const SetMap& map, const std::string& suffix) {
  if (pattern.empty()) return "";
  if (has_udim(pattern)) {
    if (map.tile.empty())
      throw Error(ErrorCode::kUsage, pattern + ": holds <UDIM>, but " + map.path + " is not a set: expected a folder");
    return with_tile(pattern, map.tile);
  }
  std::error_code error;
  const bool is_new_folder = !fs::exists(pattern, error) && fs::path(pattern).extension().empty();
  if (is_new_folder) make_folder(pattern);
  else if (!fs::is_directory(pattern, error))
    throw Error(ErrorCode::kUsage,
                pattern + ": is one file name for several maps, expected a folder, or <UDIM> in the name");
  return (fs::path(pattern) / (fs::path(map.path).stem().string() + suffix)).string();
}

}  // namespace multum
