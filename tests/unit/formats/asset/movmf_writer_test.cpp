// SPDX-License-Identifier: Apache-2.0
// Tests the writer of rows. For any portions, the pixels and the checksum equal those of the whole mipmap. Header
// values that are set last are in every part, and a failed write does not leave a file.
#include "host/formats/asset/lobes/movmf_writer.h"

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <limits>

#include "host/formats/asset/lobes/movmf_reader.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::expect_same_bits;
using testing::Names;
using testing::random_mipmap;
using testing::TemporaryFolder;

MovmfMipmap without_texels(MovmfMipmap mipmap) {
  for (MovmfLevel& level : mipmap.levels) {
    for (auto& lobe : level.lobes) lobe.clear();
    for (auto& colour : level.colours) colour.clear();
  }
  mipmap.header.provenance.measured_error = mipmap.header.provenance.content_hash = "not read";
  return mipmap;
}

// Passes every stored level in odd portions, with the levels in random order.
void write_in_portions(MovmfWriter& writer, const MovmfMipmap& mipmap, std::mt19937& random) {
  std::vector<int> next(mipmap.levels.size(), 0);
  std::vector<std::size_t> open;
  for (std::size_t l = static_cast<std::size_t>(mipmap.header.first_level); l < next.size(); ++l) open.push_back(l);
  while (!open.empty()) {
    const std::size_t pick = random() % open.size(), l = open[pick];
    const MovmfLevel& level = mipmap.levels[l];
    const int rows = std::min(level.height - next[l], static_cast<int>(random() % 23));
    if (l == 0) writer.write_finest(next[l], finest_of(level, next[l], rows));
    else writer.write_level(static_cast<int>(l), next[l], rows_of(level, next[l], rows));
    next[l] += rows;
    if (next[l] == level.height) open.erase(open.begin() + static_cast<std::ptrdiff_t>(pick));
  }
}

struct WrittenShape {
  int width, height, lobes;
  bool colours;
  int first_level;
};

// Makes random lobes, rounded as the file stores them.
MovmfMipmap rounded_mipmap(const WrittenShape& shape, StorageEncoding encoding) {
  MovmfMipmap mipmap = random_mipmap(shape.width, shape.height, shape.lobes, shape.colours, encoding, 8);
  drop_finer_levels(mipmap, shape.first_level);
  quantize_movmf(mipmap, 2);
  return mipmap;
}

class MovmfWriterTest : public ::testing::TestWithParam<WrittenShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, MovmfWriterTest,
                         ::testing::Values(WrittenShape{128, 128, 4, false, 0}, WrittenShape{201, 77, 3, true, 0},
                                           WrittenShape{1, 1, 1, false, 0}, WrittenShape{1, 1, 3, true, 0},
                                           WrittenShape{1, 97, 8, false, 0}, WrittenShape{70, 1, 2, true, 0},
                                           WrittenShape{128, 64, 2, true, 1}, WrittenShape{100, 37, 4, false, 3},
                                           WrittenShape{64, 64, 1, false, 6}));

TEST_P(MovmfWriterTest, PortionsMakeTheSameFile) {
  const WrittenShape c = GetParam();
  const unsigned seed = 31;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const TemporaryFolder folder;
  for (const StorageEncoding encoding : {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat}) {
    SCOPED_TRACE(storage_encoding_name(encoding));
    MovmfMipmap mipmap = rounded_mipmap(c, encoding);
    write_movmf_mipmap(folder / "whole.exr", mipmap, {});
    for (const int threads : {1, 3}) {
      BakedWriteOptions options;
      options.tile_size = 32;
      options.threads = threads;
      MovmfWriter writer(folder / "rows.exr", without_texels(mipmap), options);
      write_in_portions(writer, mipmap, random);
      EXPECT_FALSE(std::filesystem::exists(folder / "rows.exr"));
      writer.commit("[[0]]");
      const MovmfMipmap whole = read_movmf_mipmap(folder / "whole.exr"), rows = read_movmf_mipmap(folder / "rows.exr");
      expect_same_bits(whole, mipmap);
      expect_same_bits(rows, mipmap);
      EXPECT_EQ(rows.header.provenance.content_hash, whole.header.provenance.content_hash);
      EXPECT_EQ(rows.header.provenance.content_hash, movmf_content_hash(mipmap, 2));
      EXPECT_EQ(rows.header.provenance.content_hash, writer.content_hash());
      EXPECT_EQ(rows.header.provenance.measured_error, "[[0]]");
      EXPECT_EQ(whole.header.provenance.measured_error, "[]");
      std::filesystem::remove(folder / "rows.exr");
    }
  }
}

TEST_P(MovmfWriterTest, WhatIsKnownLastIsInEveryPart) {
  const WrittenShape c = GetParam();
  const TemporaryFolder folder;
  MovmfMipmap mipmap = rounded_mipmap(c, StorageEncoding::kSnorm16);
  // If a value contains the names and values of attributes, these are not attributes.
  mipmap.header.provenance.settings = "{\"multum:contentHash\":\"string\"}";
  mipmap.header.provenance.measured_error = "[[0,\"centre\",\"lambert\",0.25]]";
  write_movmf_mipmap(folder / "a.exr", mipmap, {});
  Imf::MultiPartInputFile file((folder / "a.exr").c_str());
  const int levels = static_cast<int>(mipmap.levels.size());
  EXPECT_EQ(file.parts(), (c.first_level == 0 ? 1 : 0) + (levels > 1 ? c.lobes * (c.colours ? 2 : 1) : 0));
  for (int part = 0; part < file.parts(); ++part) {
    const auto* hash = file.header(part).findTypedAttribute<Imf::StringAttribute>("multum:contentHash");
    ASSERT_NE(hash, nullptr);
    EXPECT_EQ(hash->value(), movmf_content_hash(mipmap, 1));
    const auto* error = file.header(part).findTypedAttribute<Imf::StringAttribute>("multum:measuredError");
    ASSERT_EQ(error != nullptr, part == 0);
    if (error != nullptr) {
      EXPECT_EQ(error->value(), mipmap.header.provenance.measured_error);
    }
  }
  EXPECT_EQ(read_movmf_header(folder / "a.exr").header.provenance.settings, mipmap.header.provenance.settings);
}

TEST_P(MovmfWriterTest, RowsAreReadAsTheyWereWritten) {
  const WrittenShape c = GetParam();
  const TemporaryFolder folder;
  MovmfMipmap mipmap = rounded_mipmap(c, StorageEncoding::kHalf);
  BakedWriteOptions options;
  options.tile_size = 16;
  write_movmf_mipmap(folder / "a.exr", mipmap, options);
  MovmfReader reader(folder / "a.exr", 2);
  EXPECT_EQ(reader.tile_size(), 16);
  EXPECT_EQ(reader.header().width(), c.width);
  std::mt19937 random(4);
  for (int l = c.first_level; l < static_cast<int>(mipmap.levels.size()); ++l) {
    const MovmfLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    for (int round = 0; round < 6; ++round) {
      const int first = static_cast<int>(random() % static_cast<unsigned>(level.height));
      const int rows = static_cast<int>(random() % static_cast<unsigned>(level.height - first + 1));
      MovmfMipmap found, expected;
      found.levels.push_back(reader.read_level(l, first, rows));
      expected.levels.push_back(rows_of(level, first, rows));
      expect_same_bits(found, expected);
      if (l > 0) continue;
      const MovmfFinest finest = reader.read_finest(first, rows), same = finest_of(level, first, rows);
      EXPECT_EQ(finest.normals, same.normals);
      EXPECT_EQ(finest.lobe, same.lobe);
      EXPECT_EQ(finest.colours, same.colours);
    }
  }
}

TEST(MovmfWriterEndTest, WithoutCommitNothingStays) {
  const TemporaryFolder folder;
  MovmfMipmap mipmap = random_mipmap(64, 64, 2, false, StorageEncoding::kFloat, 1);
  { MovmfWriter writer(folder / "a.exr", without_texels(mipmap), {}); }
  EXPECT_EQ(folder.names(), Names{});
  testing::write_bytes(folder / "a.exr", "old");
  {
    MovmfWriter writer(folder / "a.exr", without_texels(mipmap), {});
    writer.write_finest(0, finest_of(mipmap.levels[0], 0, 50));
    writer.write_level(3, 0, mipmap.levels[3]);
    EXPECT_EQ(folder.names().size(), 2u);
  }
  EXPECT_EQ(folder.names(), Names{"a.exr"});
  EXPECT_EQ(testing::read_bytes(folder / "a.exr"), "old");
}

TEST(MovmfWriterEndTest, CancelledNothingStays) {
  const TemporaryFolder folder;
  MovmfMipmap mipmap = random_mipmap(64, 64, 2, false, StorageEncoding::kFloat, 1);
  {
    MovmfWriter writer(folder / "a.exr", without_texels(mipmap), {});
    std::mt19937 random(2);
    write_in_portions(writer, mipmap, random);
    Progress progress([](const ProgressEvent&) { return false; });
    EXPECT_THROW(writer.commit("[]", &progress), Cancelled);
  }
  EXPECT_EQ(folder.names(), Names{});
}

// A file that its reader would refuse does not replace another file.
TEST(MovmfWriterEndTest, WhatWouldNotVerifyIsNotWritten) {
  const TemporaryFolder folder;
  testing::write_bytes(folder / "a.exr", "old");
  const auto write = [&](const char* check, const auto& spoil) {
    MovmfMipmap mipmap = rounded_mipmap({16, 16, 2, true, 0}, StorageEncoding::kSnorm16);
    spoil(mipmap);
    MovmfWriter writer(folder / "a.exr", without_texels(mipmap), {});
    std::mt19937 random(2);
    write_in_portions(writer, mipmap, random);
    expect_error(ErrorCode::kEnvironment, {folder / "a.exr", "fail verification", check}, [&] { writer.commit("[]"); });
  };
  write("finite", [](MovmfMipmap& m) { m.levels[2].colours[1][3].y = std::numeric_limits<float>::infinity(); });
  write("finite", [](MovmfMipmap& m) {
    const std::size_t lobe = m.levels[0].lobes[0][7].w > 0.5f ? 0 : 1;  // the lobe that holds the texel
    m.levels[0].colours[lobe][7].x = std::numeric_limits<float>::quiet_NaN();
  });
  write("sum of a", [](MovmfMipmap& m) { m.levels[1].lobes[0][5].w += 0.25f; });
  write("|r| <= 1", [](MovmfMipmap& m) { m.levels[3].lobes[1][0] = {0.9f, 0.9f, 0.9f, m.levels[3].lobes[1][0].w}; });
  EXPECT_EQ(testing::read_bytes(folder / "a.exr"), "old");
  EXPECT_EQ(folder.names(), Names{"a.exr"});
}

TEST(MovmfWriterEndTest, PlacesThatCannotBeWritten) {
  const TemporaryFolder folder;
  const MovmfMipmap mipmap = without_texels(random_mipmap(8, 8, 2, false, StorageEncoding::kFloat, 1));
  expect_error(ErrorCode::kEnvironment, {folder / "none/a.exr", "does not exist"},
               [&] { MovmfWriter(folder / "none/a.exr", mipmap, {}); });
  expect_error(ErrorCode::kUsage, {folder.path(), "is a folder"}, [&] { MovmfWriter(folder.path(), mipmap, {}); });
}

TEST(MovmfWriterEndTest, APortionLargerThanTheQueue) {
  const TemporaryFolder folder;
  MovmfMipmap mipmap = random_mipmap(1, 1, 8, false, StorageEncoding::kFloat, 1);
  mipmap.levels.clear();
  for (int side = 1024; side > 0; side /= 2) {
    mipmap.levels.push_back({side, side, {}, {}});
    mipmap.levels.back().lobes.resize(8);
  }
  const MovmfMipmap header = mipmap;
  BakedWriteOptions options;
  options.compression = "none";
  MovmfWriter writer(folder / "a.exr", header, options);
  for (int l = 0; l < 11; ++l) {
    MovmfLevel rows = header.levels[static_cast<std::size_t>(l)];
    const auto texels = static_cast<std::size_t>(rows.width) * static_cast<std::size_t>(rows.height);
    for (auto& lobe : rows.lobes) lobe.assign(texels, glm::vec4(0.0f, 0.0f, 0.125f, 0.125f));
    if (l > 0) writer.write_level(l, 0, std::move(rows));
    else
      writer.write_finest(0, {1024,
                              1024,
                              std::vector<glm::vec3>(texels, glm::vec3(0.0f, 0.0f, 1.0f)),
                              std::vector<std::uint8_t>(texels, 3),
                              {}});
  }
  writer.commit("");
  EXPECT_EQ(read_movmf_header(folder / "a.exr").header.provenance.measured_error, "");
  EXPECT_EQ(MovmfReader(folder / "a.exr").read_level(1, 511, 1).lobes[7][511], glm::vec4(0.0f, 0.0f, 0.125f, 0.125f));
}

// The disk becomes full in the headers, between tiles, or at the last byte that the library writes.
TEST(MovmfWriterEndTest, AFullDiskIsAnErrorAndNothingStays) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  MovmfMipmap mipmap = random_mipmap(300, 200, 4, true, StorageEncoding::kSnorm16, 1);
  quantize_movmf(mipmap, 2);
  write_movmf_mipmap(path, mipmap, {});
  const auto size = static_cast<rlim_t>(std::filesystem::file_size(path));
  std::filesystem::remove(path);
  for (const rlim_t bytes : {rlim_t{0}, rlim_t{5000}, size / 2, size - 70000, size - 1}) {
    SCOPED_TRACE(bytes);
    const testing::FileLimit disk(bytes);
    expect_error(ErrorCode::kEnvironment, {path + ": writing failed: ", "File too large"},
                 [&] { write_movmf_mipmap(path, mipmap, {}); });
    EXPECT_EQ(folder.names(), Names{});
  }
  {
    const testing::FileLimit disk(size);
    write_movmf_mipmap(path, mipmap, {});
  }
  expect_same_bits(read_movmf_mipmap(path), mipmap);
}

TEST(MovmfWriterDeathTest, RowsOutOfOrderOrMissing) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  const TemporaryFolder folder;
  const MovmfMipmap mipmap = random_mipmap(16, 8, 2, false, StorageEncoding::kFloat, 1);
  const auto write = [&](const std::function<void(MovmfWriter&)>& body) {
    BakedWriteOptions options;
    options.measured_error_bytes = 4;
    MovmfWriter writer(folder / "a.exr", without_texels(mipmap), options);
    body(writer);
  };
  EXPECT_DEATH(write([&](MovmfWriter& w) { w.write_level(1, 1, rows_of(mipmap.levels[1], 1, 1)); }), "rows_accepted");
  EXPECT_DEATH(write([&](MovmfWriter& w) { w.write_level(1, 0, mipmap.levels[0]); }), "height");
  EXPECT_DEATH(write([&](MovmfWriter& w) { w.commit("[]"); }), "rows_accepted");
  EXPECT_DEATH(write([&](MovmfWriter& w) {
                 std::mt19937 random(1);
                 write_in_portions(w, mipmap, random);
                 w.commit("[    ]");
               }),
               "measured_error_bytes");
}

}  // namespace
}  // namespace multum
