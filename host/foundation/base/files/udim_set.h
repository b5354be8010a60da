// SPDX-License-Identifier: Apache-2.0
// Finds sets of maps whose paths hold a placeholder for the tile. For example, rock_<UDIM>.png names rock_1001.png,
// rock_1002.png and so on.
//   <UDIM>, <udim>, %(UDIM)d   four digits, 1001 + u + 10 v: 1001 to 9999
//   <UVTILE>, <uvtile>         u1_v1, u2_v1 ...: u + 1 and v + 1
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Returns whether a path names a set.
bool has_udim(const std::string& path);

/// Returns the tiles that have files, in order. For every kind of placeholder, tiles are named "1001" and so on. Throws
/// Error(kUsage) if the placeholder is in the name of a folder.
std::vector<std::string> find_tiles(const std::string& set);
/// Returns the path with its placeholders replaced by a tile ("1001" and so on).
std::string with_tile(std::string path, const std::string& tile);

/// One of the maps that a command line names.
struct SetMap {
  std::string path;
  std::string tile;      // tile of a set; empty for a single map
  std::string set = "";  // pattern of the set, if the set also has other tiles
};

/// Returns maps in the given order. The tiles of a set are sorted by their numbers. Throws Error(kUsage) like
/// find_tiles(), and Error(kInput) if a set has no tile.
std::vector<SetMap> maps_of_names(const std::vector<std::string>& inputs);

/// Returns the output path for one of several maps. The path is `pattern` with the map's tile, or a file in the folder
/// `pattern` with the map's name and `suffix`. An empty pattern stays empty. Throws Error(kUsage) if a pattern is not a
/// folder and lacks `<UDIM>`. Creates a missing folder if its name has no extension.
std::string place_of_map(const std::string& pattern, const SetMap& map, const std::string& suffix);

}  // namespace multum
