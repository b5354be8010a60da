// SPDX-License-Identifier: Apache-2.0
// Sets of maps whose tiles are named by a word in a path, e.g. rock_<UDIM>.png for rock_1001.png, rock_1002.png ...
//   <UDIM>, <udim>, %(UDIM)d   four digits, 1001 + u + 10 v: 1001 to 9999
//   <UVTILE>, <uvtile>         u1_v1, u2_v1 ...: u + 1 and v + 1
#pragma once

#include <string>
#include <vector>

namespace multum {

/// Does a path name a set?
bool has_udim(const std::string& path);

/// The tiles that a set has files of, "1001" and so on whatever word names them, in order. Throws Error(kUsage) when
/// the word is in a folder's name.
std::vector<std::string> find_tiles(const std::string& set);
/// The path with a tile, "1001" and so on, in its words' place.
std::string with_tile(std::string path, const std::string& tile);

/// One map of those that a command line names.
struct SetMap {
  std::string path;
  std::string tile;      // of a set; empty: a map by itself
  std::string set = "";  // its pattern, where the set has other tiles too
};

/// In the order given, tiles in the order of their numbers. Throws Error(kUsage) as find_tiles() does, Error(kInput)
/// when a set has no tile.
std::vector<SetMap> maps_of_names(const std::vector<std::string>& inputs);

/// Where a file of one of several maps goes: `pattern` with the map's tile, or in the folder `pattern` under the map's
/// name with `suffix`. Empty stays empty. Makes a missing folder whose name has no extension. Throws Error(kUsage) for
/// a pattern that is neither a folder nor has `<UDIM>`.
std::string place_of_map(const std::string& pattern, const SetMap& map, const std::string& suffix);

}  // namespace multum
