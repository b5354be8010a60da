// SPDX-License-Identifier: Apache-2.0
// Compares the tiles of a set with the picture from which they were cut. Tests the slopes at the borders of tiles, and
// that all tiles use the same direction of green.
#include "host/formats/image/normals/tile_set.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include <glm/geometric.hpp>

#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/base/text_parts.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;
constexpr int kSide = 64;

double waves(int x, int y) {
  return 0.5 + 0.12 * std::sin(0.0061 * 6.2832 * (1.3 * x + 0.8 * y)) +
         0.1 * std::sin(0.0137 * 6.2832 * x - 0.04 * y + 1.0);
}

TestImage cut_image(int x0, int y0, int width, int height, TypeDesc type = TypeDesc::UINT16) {
  TestImage image{.width = width, .height = height, .channels = 1, .type = type};
  for (int y = y0; y < y0 + height; ++y)
    for (int x = x0; x < x0 + width; ++x) image.values.push_back(static_cast<float>(waves(x, y)));
  return image;
}

class TileSetTest : public ::testing::Test {
 protected:
  // Writes one tile of the set. Rows of tiles are counted from the bottom. The picture is two tiles wide and two tiles
  // high, and the sides of a tile are kSide.
  void write_tile(const std::string& tile, int u, int v, TypeDesc type = TypeDesc::UINT16) {
    write_test_image(folder_ / ("h_" + tile + ".png"), cut_image(u * kSide, (1 - v) * kSide, kSide, kSide, type));
  }
  void write_set() {
    write_tile("1001", 0, 0);
    write_tile("1002", 1, 0);
    write_tile("1011", 0, 1);
    write_tile("1012", 1, 1);
    write_test_image(folder_ / "whole.png", cut_image(0, 0, 2 * kSide, 2 * kSide));
  }
  NormalMap read_tile(const std::string& tile) {
    NormalMapSettings settings = settings_;
    TileSets().enter(folder_ / "h_<UDIM>.png", tile, settings);
    return read_map(folder_ / ("h_" + tile + ".png"), settings);
  }
  // Returns the largest angle between the normals of a tile and the normals of the whole picture at the same texels.
  double largest_angle(const NormalMap& tile, int u, int v, const NormalMap& whole) {
    double largest = 0.0;
    for (int row = 0; row < kSide; ++row)
      for (int column = 0; column < kSide; ++column) {
        const auto i = static_cast<std::size_t>(row * kSide + column),
                   j = static_cast<std::size_t>((row + (1 - v) * kSide) * whole.width + column + u * kSide);
        const glm::dvec3 a(tile.x[i], tile.y[i], tile.z[i]), b(whole.x[j], whole.y[j], whole.z[j]);
        largest = std::max(largest, glm::length(a - b) * 180.0 / 3.14159265);
      }
    return largest;
  }
  static bool has_warning(const NormalMap& map, const std::vector<std::string>& words) {
    for (const std::string& warning : map.report.warnings)
      if (std::all_of(words.begin(), words.end(), [&](const std::string& w) { return contains(warning, w); }))
        return true;
    return false;
  }

  TemporaryFolder folder_;
  NormalMapSettings settings_ = [] {
    NormalMapSettings settings;
    settings.bump_format = BumpFormat::kHeight;
    settings.height_scale = 64.0f;
    return settings;
  }();
};

TEST_F(TileSetTest, KnowsWhatIsBesideATile) {
  for (const char* tile : {"1001", "1002", "1011", "1021", "1031", "1041", "1003", "1005"})
    write_test_image(folder_ / (std::string("h_") + tile + ".png"), cut_image(0, 0, 4, 4));
  const TileSet set(folder_ / "h_<UDIM>.png");
  using Kind = TileBeside::Kind;
  const auto expect = [&](const char* tile, TileSide side, Kind kind, const char* other) {
    const TileBeside found = set.beside(tile, side);
    EXPECT_EQ(found.kind, kind) << tile << " " << tile_side_name(side);
    EXPECT_EQ(found.tile, other) << tile << " " << tile_side_name(side);
  };
  expect("1001", TileSide::kRight, Kind::kNeighbour, "1002");
  expect("1002", TileSide::kLeft, Kind::kNeighbour, "1001");
  expect("1001", TileSide::kAbove, Kind::kNeighbour, "1011");
  expect("1011", TileSide::kBelow, Kind::kNeighbour, "1001");
  expect("1001", TileSide::kBelow, Kind::kOtherEnd, "1041");
  expect("1041", TileSide::kAbove, Kind::kOtherEnd, "1001");
  expect("1003", TileSide::kRight, Kind::kGap, "1004");
  expect("1005", TileSide::kLeft, Kind::kGap, "1004");
  expect("1001", TileSide::kLeft, Kind::kBroken, "");
  expect("1002", TileSide::kAbove, Kind::kOtherEnd, "1002");
  expect("1011", TileSide::kRight, Kind::kOtherEnd, "1011");
}

// In every wrap mode, the normals of the tiles equal the normals of the whole picture, at inner and outer borders.
TEST_F(TileSetTest, TilesAreOneSurface) {
  write_set();
  for (const WrapMode mode : {WrapMode::kPeriodic, WrapMode::kClamp, WrapMode::kMirror, WrapMode::kBlack}) {
    SCOPED_TRACE(wrap_mode_name(mode));
    settings_.wrap_s = settings_.wrap_t = mode;
    const NormalMap whole = read_map(folder_ / "whole.png", settings_);
    for (const auto& [tile, u, v] : {std::tuple{"1001", 0, 0}, {"1002", 1, 0}, {"1011", 0, 1}, {"1012", 1, 1}}) {
      const NormalMap map = read_tile(tile);
      EXPECT_LT(largest_angle(map, u, v, whole), 1e-4) << tile;
      EXPECT_TRUE(contains(map.report.encoding, "continues in tile 10")) << map.report.encoding;
    }
  }
  settings_.wrap_s_origin = settings_.wrap_t_origin = WrapOrigin::kFound;
  const NormalMap whole = read_map(folder_ / "whole.png", settings_);
  EXPECT_LT(largest_angle(read_tile("1012"), 1, 1, whole), 1e-4) << whole.report.encoding_reason;
}

TEST_F(TileSetTest, MissingAndUnlikeTilesEndTheSurface) {
  settings_.wrap_s = settings_.wrap_t = WrapMode::kPeriodic;
  write_tile("1001", 0, 0);
  write_tile("1003", 1, 0);
  const NormalMap beside_gap = read_tile("1001");
  EXPECT_TRUE(has_warning(beside_gap, {"missing tile 1002", "right", "end"}));
  settings_.wrap_s = WrapMode::kClamp;
  const NormalMap alone = read_map(folder_ / "h_1001.png", settings_);
  EXPECT_EQ(beside_gap.x, alone.x) << "differences are one-sided at the gap and where the row does not repeat";
  write_test_image(folder_ / "h_1002.png", cut_image(kSide, 0, kSide / 2, kSide / 2));
  const NormalMap beside_small = read_tile("1001");
  EXPECT_TRUE(has_warning(beside_small, {"tile 1002", "32 x 32 texels, expected 64 x 64"}));
  EXPECT_EQ(beside_small.x, alone.x);
  std::filesystem::remove(folder_ / "h_1003.png");
  TestImage broken = normal_image(kSide, kSide);
  write_test_image(folder_ / "h_1002.png", broken);
  EXPECT_TRUE(has_warning(read_tile("1001"), {"tile 1002", "not contain heights of this kind"}));
}

TEST_F(TileSetTest, DequantizedTilesMeet) {
  settings_.height_scale = 256.0f;
  settings_.dequantize = true;
  settings_.wrap_s = settings_.wrap_t = WrapMode::kClamp;
  for (const auto& [tile, u, v] : {std::tuple{"1001", 0, 0}, {"1002", 1, 0}}) write_tile(tile, u, v, TypeDesc::UINT8);
  write_test_image(folder_ / "fine.png", cut_image(0, 0, 2 * kSide, 2 * kSide));
  const NormalMap fine = read_map(folder_ / "fine.png", settings_);
  const auto border_error = [&](const NormalMap& left) {
    double sum = 0.0;
    for (int row = 1; row + 1 < kSide; ++row) {
      const auto i = static_cast<std::size_t>(row * kSide + kSide - 1),
                 j = static_cast<std::size_t>((row + kSide) * fine.width + kSide - 1);
      sum += std::abs(static_cast<double>(left.x[i] / left.z[i] - fine.x[j] / fine.z[j]));
    }
    return sum / (kSide - 2);
  };
  const double dequantized = border_error(read_tile("1001"));
  settings_.dequantize = false;
  EXPECT_LT(dequantized, 0.5 * border_error(read_tile("1001")));
}

// The hash of a tile includes the border of the next tile, but not the inside of the next tile.
TEST_F(TileSetTest, ARecordKnowsTheBordersOfOthers) {
  write_set();
  const std::string record = read_tile("1001").report.tiles;
  const auto is_unchanged = [&] {
    TileSet set(folder_ / "h_<UDIM>.png");
    return tiles_are_unchanged(record, set, "1001", settings_.fix_nan);
  };
  EXPECT_TRUE(is_unchanged());
  TestImage edited = cut_image(kSide, kSide, kSide, kSide);
  edited.at(30, 30, 0) = 0.9f;
  write_test_image(folder_ / "h_1002.png", edited);
  EXPECT_TRUE(is_unchanged());
  EXPECT_EQ(tile_source_hash("a", read_tile("1001").report.tiles), tile_source_hash("a", record));
  edited.at(0, 30, 0) = 0.9f;
  write_test_image(folder_ / "h_1002.png", edited);
  EXPECT_FALSE(is_unchanged());
  EXPECT_NE(tile_source_hash("a", read_tile("1001").report.tiles), tile_source_hash("a", record));
  write_tile("1002", 1, 0);
  EXPECT_TRUE(is_unchanged());
  std::filesystem::remove(folder_ / "h_1002.png");
  EXPECT_FALSE(is_unchanged());
  // If the surface repeats, the tile at the other end of the row counts as a neighbour.
  write_set();
  write_tile("1003", 2, 0);
  for (const WrapMode mode : {WrapMode::kPeriodic, WrapMode::kClamp}) {
    settings_.wrap_s = settings_.wrap_t = mode;
    write_tile("1003", 2, 0);
    const std::string of_end = read_tile("1001").report.tiles;
    TestImage other = cut_image(2 * kSide, kSide, kSide, kSide);
    other.at(kSide - 1, 5, 0) = 0.1f;
    write_test_image(folder_ / "h_1003.png", other);
    TileSet set(folder_ / "h_<UDIM>.png");
    EXPECT_EQ(tiles_are_unchanged(of_end, set, "1001", settings_.fix_nan), mode == WrapMode::kClamp);
  }
  for (const char* damaged : {"{}", "no JSON", "{\"heights\": 3}", "{\"green\": {\"tiles\": [7]}}"}) {
    TileSet set(folder_ / "h_<UDIM>.png");
    tiles_are_unchanged(damaged, set, "1001", settings_.fix_nan);  // does not throw
  }
}

// A flat tile does not show the direction of green, and another tile may be painted with the opposite direction. The
// first tile that shows a direction decides for all tiles.
TEST_F(TileSetTest, GreenIsThatOfTheSet) {
  settings_ = {};
  TestImage flat = normal_image(kSide, kSide);
  for (std::size_t i = 0; i < flat.values.size(); ++i) flat.values[i] = i % 3 == 2 ? 1.0f : 0.5f;
  flat.at(3, 3, 1) = flat.at(9, 30, 1) = 0.6f;
  write_test_image(folder_ / "h_1001.png", flat);
  write_test_image(folder_ / "h_1002.png", normal_image(kSide, kSide, false, -1.0));
  write_test_image(folder_ / "h_1003.png", normal_image(kSide, kSide, false, 1.0));
  const NormalMap first = read_tile("1001"), second = read_tile("1002"), third = read_tile("1003");
  for (const NormalMap* map : {&first, &second, &third})
    EXPECT_TRUE(contains(map->report.encoding, "green down")) << map->report.encoding;
  EXPECT_TRUE(contains(first.report.encoding, "as in its set"));
  EXPECT_FALSE(has_warning(first, {"--green"}));
  EXPECT_FALSE(has_warning(second, {"--green"}));
  EXPECT_TRUE(has_warning(third, {"--green up or --green down", "green points up"}));
  TileSet set(folder_ / "h_<UDIM>.png");
  EXPECT_TRUE(tiles_are_unchanged(third.report.tiles, set, "1003", FixNan::kBox3));
  write_test_image(folder_ / "h_1001.png", normal_image(kSide, kSide));
  TileSet again(folder_ / "h_<UDIM>.png");
  EXPECT_FALSE(tiles_are_unchanged(third.report.tiles, again, "1003", FixNan::kBox3));
}

// Tiles are read in parallel. A thread that needs the set's direction of green waits until another thread has found it.
TEST_F(TileSetTest, ThreadsAgreeOnGreen) {
  write_tile("1001", 0, 0);
  TileSet set(folder_ / "h_<UDIM>.png");
  std::atomic<bool> is_asking = false, comes_another = false;
  std::optional<GreenAxis> first;
  std::thread asks([&] {
    first = set.green([&](const std::string&) {
                 is_asking = true;
                 while (!comes_another) std::this_thread::yield();
                 std::this_thread::sleep_for(std::chrono::milliseconds(50));
                 return std::optional(GreenAxis::kDown);
               })
                .axis;
  });
  while (!is_asking) std::this_thread::yield();
  comes_another = true;
  const TileSet::Green second = set.green([](const std::string&) { return std::optional(GreenAxis::kUp); });
  asks.join();
  EXPECT_EQ(first, GreenAxis::kDown);
  EXPECT_EQ(second.axis, GreenAxis::kDown);
}

}  // namespace
}  // namespace multum::testing
