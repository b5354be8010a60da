// SPDX-License-Identifier: Apache-2.0
// Tests that the storage of an image and the number of rows per band do not change a bit of the result, a count or an
// error message. Scratch files are invisible, and no trace of them remains.
#include "host/formats/image/plane_store.h"
#include "host/foundation/base/files/spill_policy.h"

#include <cmath>
#include <cstring>

#include "host/formats/image/colour_map.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

using OIIO::TypeDesc;

using Planes = std::array<std::vector<float>, 3>;

Planes planes_of(const PlaneStore& store) {
  Planes planes;
  for (std::vector<float>& plane : planes) plane.resize(static_cast<std::size_t>(store.width() * store.height()));
  store.read_rows(0, store.height(), {planes[0].data(), planes[1].data(), planes[2].data()});
  return planes;
}

void expect_same_bits(const Planes& found, const Planes& expected) {
  for (std::size_t p = 0; p < 3; ++p) {
    ASSERT_EQ(found[p].size(), expected[p].size());
    EXPECT_EQ(std::memcmp(found[p].data(), expected[p].data(), found[p].size() * sizeof(float)), 0) << "plane " << p;
  }
}

void expect_same_report(const NormalMapReport& found, const NormalMapReport& expected) {
  EXPECT_EQ(found.format, expected.format);
  EXPECT_EQ(found.encoding, expected.encoding);
  EXPECT_EQ(found.encoding_reason, expected.encoding_reason);
  EXPECT_EQ(found.unused_texels, expected.unused_texels);
  EXPECT_EQ(found.nonfinite_repaired, expected.nonfinite_repaired);
  EXPECT_EQ(found.zero_length_repaired, expected.zero_length_repaired);
  EXPECT_EQ(found.below_horizon_repaired, expected.below_horizon_repaired);
  EXPECT_EQ(found.warnings, expected.warnings);
}

class ReadingRowsTest : public ::testing::Test {
 protected:
  // Runs with scratch files, in memory, and with a mix of both, which a limit of 4096 bytes gives for the sizes here.
  template <typename Body>
  void for_each_place(const Body& body) {
    for (const int band_rows : {1, 2, 7, 0}) {
      for (const std::int64_t memory_bytes : {std::int64_t{0}, std::int64_t{4096}, SpillPolicy().memory_bytes}) {
        SCOPED_TRACE("bands of " + std::to_string(band_rows) + ", memory of " + std::to_string(memory_bytes));
        body(SpillPolicy{scratch_.path(), memory_bytes, band_rows});
        EXPECT_TRUE(scratch_.names().empty());
      }
    }
  }
  // All kinds of storage give the same result as a map that is completely in memory and is read in one band.
  void expect_same_everywhere(const std::string& path, const NormalMapSettings& settings = {}) {
    SCOPED_TRACE(path);
    const NormalMap whole = read_map(path, settings);
    for_each_place([&](const SpillPolicy& spill) {
      for (const int threads : {1, 3}) {
        const NormalMapRows rows = read_normal_map_rows(path, settings, spill, threads, nullptr);
        ASSERT_EQ(rows.normals.width(), whole.width);
        expect_same_bits(planes_of(rows.normals), {whole.x, whole.y, whole.z});
        expect_same_report(rows.report, whole.report);
      }
    });
  }
  std::string write(const std::string& name, const TestImage& image) {
    write_test_image(folder_ / name, image);
    return folder_ / name;
  }
  TemporaryFolder folder_;
  TemporaryFolder scratch_;
};

TEST_F(ReadingRowsTest, NormalMapsOfEveryKind) {
  for (const auto& [width, height] : {std::pair{61, 47}, {1, 33}, {33, 1}}) {
    for (const TypeDesc::BASETYPE type : {TypeDesc::UINT8, TypeDesc::UINT16}) {
      TestImage image = normal_image(width, height);
      image.type = type;
      expect_same_everywhere(write("a.png", image));
      image.tile_size = 16;
      expect_same_everywhere(write("tiled.tif", image));
    }
    for (const bool is_signed : {false, true}) {
      TestImage image = normal_image(width, height, is_signed, -1.0);
      image.type = TypeDesc::HALF;
      expect_same_everywhere(write("a.exr", image));
      image.tile_size = 16;
      expect_same_everywhere(write("tiled.exr", image));
    }
  }
}

TEST_F(ReadingRowsTest, TwoChannelsAndConstantBlue) {
  TestImage image = normal_image(61, 47);
  image.type = TypeDesc::UINT16;
  for (std::size_t i = 2; i < image.values.size(); i += 3) image.values[i] = 0.5f;
  expect_same_everywhere(write("blue.png", image));
  TestImage two{.width = 61, .height = 47, .channels = 2, .type = TypeDesc::FLOAT, .channel_names = {"R", "G"}};
  for (std::size_t i = 0; i < image.values.size(); ++i)
    if (i % 3 != 2) two.values.push_back(image.values[i] * 2.0f - 1.0f);
  two.at(5, 13, 1) = kNan;
  expect_same_everywhere(write("two.exr", two));
}

// Every row has holes of every kind, some below one another, so each band has one at its border.
TEST_F(ReadingRowsTest, RepairsReachOverTheBorders) {
  TestImage image = normal_image(61, 47, true);
  image.type = TypeDesc::FLOAT;
  for (int row = 0; row < image.height; ++row) {
    for (const int column : {5, 20 + row % 3, 60}) {
      image.at(column, row, 0) = row % 2 == 0 ? kNan : 0.0f;
      image.at(column, row, 1) = row % 5 == 0 ? -kInf : 0.0f;
      image.at(column, row, 2) = row % 7 == 0 ? -1.0f : 0.0f;
    }
  }
  NormalMapSettings settings;
  settings.repair_share_max = 1.0f;
  settings.bump_format = BumpFormat::kNormal;
  for (const FixNan fix_nan : {FixNan::kBox3, FixNan::kBlack}) {
    settings.fix_nan = fix_nan;
    expect_same_everywhere(write("holes.exr", image), settings);
    image.tile_size = 16;
    expect_same_everywhere(write("holes.tif", image), settings);
    image.tile_size = 0;
  }
}

TEST_F(ReadingRowsTest, HeightsWithEveryWrapMode) {
  TestImage image{.width = 23, .height = 19, .channels = 1, .type = TypeDesc::FLOAT, .channel_names = {"Y"}};
  for (int i = 0; i < image.width * image.height; ++i) image.values.push_back(std::sin(0.3f * static_cast<float>(i)));
  const std::string path = write("h.exr", image);
  for (int row = 0; row < image.height; ++row) image.at(row % 3, row, 0) = row % 2 == 0 ? kNan : kInf;
  const std::string holes = write("holes.exr", image);
  NormalMapSettings settings;
  settings.repair_share_max = 1.0f;
  for (const WrapMode mode : {WrapMode::kPeriodic, WrapMode::kClamp, WrapMode::kMirror, WrapMode::kBlack}) {
    settings.wrap_s = settings.wrap_t = mode;
    expect_same_everywhere(path, settings);
    expect_same_everywhere(holes, settings);
  }
  settings.fix_nan = FixNan::kBlack;
  expect_same_everywhere(holes, settings);
}

TEST_F(ReadingRowsTest, HeightsOfThreeChannels) {
  TestImage image{.width = 23, .height = 19, .type = TypeDesc::UINT16};
  for (int i = 0; i < image.width * image.height; ++i)
    image.values.insert(image.values.end(), 3, 0.5f + 0.5f * std::sin(0.3f * static_cast<float>(i)));
  expect_same_everywhere(write("grey.png", image));
}

// A PNG with text chunks before and after its picture is read from its file; the text is skipped.
TEST_F(ReadingRowsTest, MetadataIsPassedOver) {
  TestImage image = normal_image(61, 47);
  const NormalMap plain = read_map(write("a.png", image));
  std::string bytes = read_bytes(folder_ / "a.png");
  const std::string text("\0\0\0\5zTXtabcde....", 17);  // readers must skip it: its CRC is wrong
  bytes.insert(bytes.size() - 12, text);
  bytes.insert(33, text);
  write_bytes(folder_ / "a.png", bytes);
  EXPECT_EQ(read_map(folder_ / "a.png").x, plain.x);
  expect_same_everywhere(folder_ / "a.png");
}

TEST_F(ReadingRowsTest, AlbedoOfEveryKind) {
  TestImage image = normal_image(61, 47);
  TestImage floats{.width = 61, .height = 47, .channels = 1, .type = TypeDesc::FLOAT, .channel_names = {"Y"}};
  for (std::size_t i = 0; i < image.values.size(); i += 3) floats.values.push_back(image.values[i]);
  for (int row = 0; row < 47; ++row) floats.at(row, row, 0) = row % 2 == 0 ? kNan : -1.0f;
  image.colour_space = "sRGB";
  std::vector<std::string> paths = {write("a.png", image), write("a.exr", floats)};
  image.type = TypeDesc::UINT16;
  image.tile_size = 16;
  paths.push_back(write("a.tif", image));
  for (const std::string& path : paths) {
    SCOPED_TRACE(path);
    const ColourMap whole = read_albedo_map(path, 61, 47, 2);
    for_each_place([&](const SpillPolicy& spill) {
      for (const int threads : {1, 3})
        expect_same_bits(planes_of(read_albedo_rows(path, 61, 47, spill, threads).planes), {whole.r, whole.g, whole.b});
    });
  }
}

// The faults that cause a refusal are counted over all bands.
TEST_F(ReadingRowsTest, RefusalsNameTheSame) {
  TestImage image = normal_image(64, 64, true);
  image.type = TypeDesc::FLOAT;
  for (int row = 0; row < 41; ++row) image.at(7, row + 10, 0) = kNan;
  const std::string path = write("a.exr", image);
  NormalMapSettings strict;
  strict.check_nan = true;
  for_each_place([&](const SpillPolicy& spill) {
    expect_error(ErrorCode::kInput, {"a.exr", "41 of 4096", "1.00 %", "41 not finite"},
                 [&] { read_normal_map_rows(path, {}, spill, 2, nullptr); });
    expect_error(ErrorCode::kInput, {"column 7, row 10", "41 texels"},
                 [&] { read_normal_map_rows(path, strict, spill, 2, nullptr); });
  });
}

TEST_F(ReadingRowsTest, AFolderThatIsNotThereIsNamed) {
  const std::string path = write("a.png", normal_image(64, 64));
  const SpillPolicy spill{"/no/such/folder", 0};
  expect_error(ErrorCode::kEnvironment, {"/no/such/folder"},
               [&] { read_normal_map_rows(path, {}, spill, 2, nullptr); });
  expect_error(ErrorCode::kEnvironment, {"/no/such/folder"}, [&] { read_albedo_rows(path, 64, 64, spill, 2); });
}

TEST_F(ReadingRowsTest, CancellingAtAnyCallLeavesNothing) {
  const std::string path = write("a.png", normal_image(64, 64));
  const SpillPolicy spill{scratch_.path(), 0, 8};
  int call_count = 0;
  Progress counting([&](const ProgressEvent&) { return ++call_count > 0; });
  read_normal_map_rows(path, {}, spill, 2, &counting);
  EXPECT_GE(call_count, 3 + 8);  // three stages, eight bands
  for (int stop_at = 1; stop_at <= call_count; ++stop_at) {
    int calls = 0;
    Progress progress([&](const ProgressEvent&) { return ++calls < stop_at; });
    EXPECT_THROW(read_normal_map_rows(path, {}, spill, 2, &progress), Cancelled) << stop_at;
    EXPECT_TRUE(scratch_.names().empty());
  }
}

}  // namespace
}  // namespace multum::testing
