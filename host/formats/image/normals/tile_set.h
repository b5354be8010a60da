// SPDX-License-Identifier: Apache-2.0
// A set of UDIM tiles (host/foundation/base/files/udim_set.h) that is read as one surface. Heights continue in
// neighbouring tiles, and green has the same direction in all tiles. The bake of one tile reads the borders of the
// other tiles itself, so the tiles of a set can be baked on any number of machines.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/image/normals/height_surface.h"
#include "host/foundation/base/files/input_hashes.h"

namespace multum {

enum class TileSide { kLeft, kRight, kAbove, kBelow };
constexpr TileSide kTileSides[] = {TileSide::kLeft, TileSide::kRight, TileSide::kAbove, TileSide::kBelow};
const char* tile_side_name(TileSide side);

/// The place next to one side of a tile.
struct TileBeside {
  enum class Kind {
    kNeighbour,  // another tile
    kOtherEnd,   // last tile of a complete, repeating row or column; it may be the tile itself
    kGap,        // `tile` is missing between two tiles of the row or column
    kBroken      // end of a row or column that has a gap elsewhere
  };
  Kind kind = Kind::kOtherEnd;
  std::string tile;
};

/// The borders of a tile's heights. They are BorderReading::depth rows and columns, with the row and column numbers of
/// the tile itself.
struct TileBorders {
  int width = 0, height = 0, base_type = 0;
  std::string failure;                                      // the reason why there are no borders; empty if there are
                                                            // borders
  std::array<std::shared_ptr<const HeightRows>, 4> strips;  // index: TileSide
  std::array<std::string, 4> hashes;                        // SHA-256 of each strip
};

class TileSet {
 public:
  /// Finds the existing tiles. Throws Error(kUsage) like find_tiles().
  explicit TileSet(const std::string& pattern);

  const std::vector<std::string>& tiles() const { return tiles_; }
  std::string path(const std::string& tile) const;
  TileBeside beside(const std::string& tile, TileSide side) const;

  /// The settings with which borders are read.
  struct BorderReading {
    HeightCoding coding = HeightCoding::kGrey;
    int depth = 1;
    FixNan fix_nan = FixNan::kBox3;
    auto operator<=>(const BorderReading&) const = default;
  };
  /// Returns the borders of a tile. Each tile is read only once.
  const TileBorders& borders(const std::string& tile, const BorderReading& reading, const SpillPolicy& spill);
  /// Returns the SHA-256 of the file of a tile. The file is read only once.
  std::string file_hash(const std::string& tile);

  /// Returns the direction of green in the first tile that decides it. `of_tile` returns the direction of green that
  /// was found in one tile, or nullopt if it is unknown. `of_tile` is called in the order of the tiles, at most once
  /// for each of them.
  struct Green {
    std::optional<GreenAxis> axis;
    std::vector<std::string> asked;  // examined tiles; the last one decided
  };
  Green green(const std::function<std::optional<GreenAxis>(const std::string& tile)>& of_tile);

 private:
  std::string pattern_;
  std::vector<std::string> tiles_;
  std::mutex mutex_;
  InputHashes hashes_;
  std::map<std::pair<std::string, BorderReading>, TileBorders> borders_;
  std::map<std::string, std::optional<GreenAxis>> greens_;
};

/// The sets of a run, each of which is opened once.
class TileSets {
 public:
  /// Stores in `settings` the set to which a map belongs, and its tile in the set. Stores nothing if the tile has no
  /// neighbours.
  void enter(const std::string& pattern, const std::string& tile, NormalMapSettings& settings);

 private:
  std::map<std::string, std::shared_ptr<TileSet>> sets_;
};

/// The surface beyond the borders of a tile's heights.
struct TileSurroundings {
  HeightSides neighbours;  // neighbouring tiles; kEnd for a side without a neighbour
  HeightSides repeated;    // other ends, if the surface repeats and a side has no neighbour; otherwise kEnd
  bool has_neighbour_s = false, has_neighbour_t = false;
  std::string text;  // "continues in tile 1002 (right)"
  std::vector<std::string> warnings;
  std::string record;  // JSON, for tiles_are_unchanged()
};
/// Directions in which a surface can repeat. The other end of a row or column matters only in these directions.
struct TileRepeats {
  bool s = true, t = true;
};
TileSurroundings tile_surroundings(TileSet& set, const std::string& tile, const RawImageInfo& info,
                                   const TileRepeats& repeats, const TileSet::BorderReading& reading,
                                   const SpillPolicy& spill);

/// Adds to a record the tiles that decided the direction of green. The record may be empty.
std::string with_green(const std::string& record, TileSet& set, const TileSet::Green& green);

/// Returns whether the record of an older bake equals the current state. Does not read tiles whose files are unchanged.
bool tiles_are_unchanged(const std::string& record, TileSet& set, const std::string& tile, FixNan fix_nan);

/// Returns the hash of a tile in the state in which it was read. The hash covers its own file and the parts of other
/// tiles that `record` lists.
std::string tile_source_hash(const std::string& file_hash, const std::string& record);

}  // namespace multum
