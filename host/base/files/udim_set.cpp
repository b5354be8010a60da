// SPDX-License-Identifier: Apache-2.0
#include "host/base/files/udim_set.h"

#include <algorithm>
#include <filesystem>

#include "host/base/error.h"

namespace multum {
namespace {

namespace fs = std::filesystem;

constexpr char kUdim[] = "<UDIM>";
constexpr std::size_t kTileDigits = 4;

bool is_tile(const std::string& text) {
  return text.size() == kTileDigits &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; }) && text > "1000";
}

}  // namespace

bool has_udim(const std::string& path) { return path.find(kUdim) != std::string::npos; }

std::string with_tile(std::string path, const std::string& tile) {
  for (std::size_t at = path.find(kUdim); at != std::string::npos; at = path.find(kUdim, at))
    path.replace(at, sizeof(kUdim) - 1, tile);
  return path;
}

std::vector<std::string> find_tiles(const std::string& set) {
  const fs::path path(set);
  const std::string name = path.filename().string();
  const std::size_t at = name.find(kUdim);
  if (at == std::string::npos)
    throw Error(ErrorCode::kUsage, set + ": found <UDIM> in a folder's name, expected it in the file's");
  std::vector<std::string> tiles;
  std::error_code none;
  for (const fs::directory_entry& entry :
       fs::directory_iterator(path.has_parent_path() ? path.parent_path() : fs::path("."), none)) {
    const std::string found = entry.path().filename().string();
    if (found.size() < at + kTileDigits) continue;
    const std::string tile = found.substr(at, kTileDigits);
    if (is_tile(tile) && found == with_tile(name, tile)) tiles.push_back(tile);
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
    for (const std::string& tile : tiles) maps.push_back({with_tile(input, tile), tile});
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
  if (!fs::is_directory(pattern, error))
    throw Error(ErrorCode::kUsage,
                pattern + ": one name for several maps, expected a folder that exists, or <UDIM> in the name");
  return (fs::path(pattern) / (fs::path(map.path).stem().string() + suffix)).string();
}

}  // namespace multum
