// SPDX-License-Identifier: Apache-2.0
// A set of UDIM tiles (host/foundation/base/files/udim_set.h), read as one surface: heights go on in the tiles beside a
// tile, and green points the same way in all of them. Whoever bakes one tile reads the others' borders itself, so that
// the tiles of a set can be dealt out to any number of machines.
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

/// What is on one side of a tile.
struct TileBeside {
  enum class Kind {
    kNeighbour,  // another tile
    kOtherEnd,   // the last tile of a whole row or column, which repeats; the tile itself where it is alone in it
    kGap,        // `tile` is missing between two of its row or column
    kBroken      // the end of a row or column that has a gap elsewhere
  };
  Kind kind = Kind::kOtherEnd;
  std::string tile;
};

/// The borders of a tile's heights, of TileSet::depth rows and columns, in the tile's own numbers of rows and columns.
struct TileBorders {
  int width = 0, height = 0, base_type = 0;
  std::string failure;                                      // why there are none; empty: here they are
  std::array<std::shared_ptr<const HeightRows>, 4> strips;  // by TileSide
  std::array<std::string, 4> hashes;                        // SHA-256 of them
};

class TileSet {
 public:
  /// The tiles that are there now. Throws Error(kUsage) as find_tiles() does.
  explicit TileSet(const std::string& pattern);

  const std::vector<std::string>& tiles() const { return tiles_; }
  std::string path(const std::string& tile) const;
  TileBeside beside(const std::string& tile, TileSide side) const;

  /// How borders are read.
  struct BorderReading {
    HeightCoding coding = HeightCoding::kGrey;
    int depth = 1;
    FixNan fix_nan = FixNan::kBox3;
    auto operator<=>(const BorderReading&) const = default;
  };
  /// Each read once.
  const TileBorders& borders(const std::string& tile, const BorderReading& reading, const SpillPolicy& spill);
  /// SHA-256 of a tile's file, read once.
  std::string file_hash(const std::string& tile);

  /// Green of the set: of the first tile that can tell. `of_tile` says what a tile by itself has, nullopt where it
  /// cannot tell; each is asked at most once, in the order of the tiles.
  struct Green {
    std::optional<GreenAxis> axis;
    std::vector<std::string> asked;  // the last of them decided
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

/// The sets of a run, each once.
class TileSets {
 public:
  /// Says in `settings` which tile of which set a map is; nothing where it has none beside it.
  void enter(const std::string& pattern, const std::string& tile, NormalMapSettings& settings);

 private:
  std::map<std::string, std::shared_ptr<TileSet>> sets_;
};

/// What lies beyond the borders of a tile's heights.
struct TileSurroundings {
  HeightSides neighbours;  // tiles beside it; kEnd where there is none
  HeightSides repeated;    // where the surface repeats: the other ends, on sides without a neighbour; else kEnd
  bool has_neighbour_s = false, has_neighbour_t = false;
  std::string text;  // "goes on in 1002 (right)"
  std::vector<std::string> warnings;
  std::string record;  // JSON, for tiles_are_unchanged()
};
/// Directions in which a surface may repeat: other ends are looked at there alone.
struct TileRepeats {
  bool s = true, t = true;
};
TileSurroundings tile_surroundings(TileSet& set, const std::string& tile, const RawImageInfo& info,
                                   const TileRepeats& repeats, const TileSet::BorderReading& reading,
                                   const SpillPolicy& spill);

/// Adds who decided about green to a record, which may be empty.
std::string with_green(const std::string& record, TileSet& set, const TileSet::Green& green);

/// Whether a record, of a bake from before, is what would be found now. A tile whose file is the same is not read.
bool tiles_are_unchanged(const std::string& record, TileSet& set, const std::string& tile, FixNan fix_nan);

/// The hash of a tile as it was read: of its own file and of what `record` says was taken from others.
std::string tile_source_hash(const std::string& file_hash, const std::string& record);

}  // namespace multum
