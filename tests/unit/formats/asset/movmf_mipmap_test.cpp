// SPDX-License-Identifier: Apache-2.0
// Tests that a baked file reads back bit for bit.
#include "host/formats/asset/lobes/movmf_mipmap.h"

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfTiledInputPart.h>
#include <gtest/gtest.h>

#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::expect_same_bits;
using testing::random_mipmap;
using testing::read_bytes;
using testing::TemporaryFolder;

struct RoundTrip {
  int width, height, lobes;
  bool colours;
};

class MovmfRoundTripTest : public ::testing::TestWithParam<RoundTrip> {};
INSTANTIATE_TEST_SUITE_P(Sizes, MovmfRoundTripTest,
                         ::testing::Values(RoundTrip{128, 128, 4, false}, RoundTrip{100, 37, 4, true},
                                           RoundTrip{1, 1, 1, true}, RoundTrip{1, 97, 8, false},
                                           RoundTrip{70, 1, 2, true}, RoundTrip{65, 64, 1, false}));

TEST_P(MovmfRoundTripTest, BitForBitInEveryEncodingAndCompression) {
  const RoundTrip c = GetParam();
  const TemporaryFolder folder;
  for (const StorageEncoding encoding : {StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat}) {
    MovmfMipmap mipmap = random_mipmap(c.width, c.height, c.lobes, c.colours, encoding, 3);
    quantize_movmf(mipmap, 2);
    for (const char* compression : {"none", "rle", "zips", "zip", "zip:1", "zips:9", "piz"}) {
      SCOPED_TRACE(std::string(storage_encoding_name(encoding)) + " " + compression);
      BakedWriteOptions options;
      options.compression = compression;
      write_movmf_mipmap(folder / "a.ndf.exr", mipmap, options);
      const MovmfMipmap found = read_movmf_mipmap(folder / "a.ndf.exr");
      expect_same_bits(found, mipmap);
      EXPECT_EQ(found.header.encoding, encoding);
      EXPECT_EQ(found.header.wrap_s, mipmap.header.wrap_s);
      EXPECT_EQ(found.header.wrap_t, mipmap.header.wrap_t);
      EXPECT_EQ(found.header.provenance.software, mipmap.header.provenance.software);
      EXPECT_EQ(found.header.provenance.source_name, mipmap.header.provenance.source_name);
      EXPECT_EQ(found.header.provenance.source_hash, mipmap.header.provenance.source_hash);
      EXPECT_EQ(found.header.provenance.settings, mipmap.header.provenance.settings);
      EXPECT_EQ(found.header.provenance.settings_hash, mipmap.header.provenance.settings_hash);
      EXPECT_EQ(found.header.provenance.measured_error, mipmap.header.provenance.measured_error);
      EXPECT_EQ(found.header.provenance.content_hash, movmf_content_hash(mipmap, 1));
    }
  }
}

TEST(MovmfMipmapTest, BytesDoNotDependOnThreads) {
  const TemporaryFolder folder;
  MovmfMipmap one = random_mipmap(150, 70, 4, true, StorageEncoding::kSnorm16, 5);
  MovmfMipmap three = one;
  quantize_movmf(one, 1);
  quantize_movmf(three, 3);
  expect_same_bits(three, one);
  EXPECT_EQ(movmf_content_hash(one, 1), movmf_content_hash(one, 5));
  BakedWriteOptions options;
  options.threads = 1;
  write_movmf_mipmap(folder / "1.exr", one, options);
  options.threads = 3;
  write_movmf_mipmap(folder / "3.exr", three, options);
  EXPECT_EQ(read_bytes(folder / "1.exr"), read_bytes(folder / "3.exr"));
}

TEST(MovmfMipmapTest, HeaderAloneHasSizesAndNoPixels) {
  const TemporaryFolder folder;
  write_movmf_mipmap(folder / "a.exr", random_mipmap(20, 7, 3, true, StorageEncoding::kFloat, 1), {});
  const MovmfMipmap header = read_movmf_header(folder / "a.exr");
  EXPECT_EQ(header.width(), 20);
  EXPECT_EQ(header.height(), 7);
  EXPECT_EQ(header.lobe_count(), 3);
  EXPECT_TRUE(header.has_colours());
  ASSERT_EQ(header.levels.size(), 5u);
  EXPECT_EQ(header.levels[2].width, 5);
  EXPECT_EQ(header.levels[2].height, 1);
  EXPECT_TRUE(header.levels[0].lobes[0].empty());
}

class FirstLevelTest : public ::testing::TestWithParam<RoundTrip> {};
INSTANTIATE_TEST_SUITE_P(Sizes, FirstLevelTest,
                         ::testing::Values(RoundTrip{128, 128, 4, false}, RoundTrip{100, 37, 3, true},
                                           RoundTrip{1, 97, 2, true}, RoundTrip{70, 1, 1, false}));

TEST_P(FirstLevelTest, WhatIsStoredIsReadBitForBitFromWhateverLevelOn) {
  const RoundTrip c = GetParam();
  const TemporaryFolder folder;
  MovmfMipmap mipmap = random_mipmap(c.width, c.height, c.lobes, c.colours, StorageEncoding::kSnorm16, 9);
  quantize_movmf(mipmap, 1);
  const int level_count = static_cast<int>(mipmap.levels.size());
  std::string hash = movmf_content_hash(mipmap, 1);
  for (int first_level = 1; first_level < level_count; ++first_level) {
    SCOPED_TRACE(first_level);
    MovmfMipmap dropped = mipmap;
    drop_finer_levels(dropped, first_level);
    quantize_movmf(dropped, 1);  // levels without texels are skipped, and the other levels are already rounded
    write_movmf_mipmap(folder / "a.exr", dropped, {});
    const MovmfMipmap found = read_movmf_mipmap(folder / "a.exr");
    EXPECT_EQ(found.header.first_level, first_level);
    EXPECT_EQ(found.width(), c.width);
    EXPECT_EQ(found.height(), c.height);
    EXPECT_EQ(found.lobe_count(), c.lobes);
    EXPECT_EQ(found.has_colours(), c.colours);
    expect_same_bits(found, dropped);
    for (int l = 0; l < level_count; ++l)
      EXPECT_EQ(found.levels[static_cast<std::size_t>(l)].lobes[0].empty(), l < first_level) << l;
    EXPECT_EQ(found.header.provenance.content_hash, movmf_content_hash(dropped, 2));
    EXPECT_NE(found.header.provenance.content_hash, hash) << "one level less changes the checksum";
    hash = found.header.provenance.content_hash;
    const MovmfMipmap header = read_movmf_header(folder / "a.exr");
    EXPECT_EQ(header.header.first_level, first_level);
    EXPECT_EQ(header.width(), c.width);
    const std::string last = std::to_string(level_count - 1), first = std::to_string(first_level);
    EXPECT_EQ(levels_text(header), (first == last ? "level " : "levels " + first + " to ") + last + " of 0 to " + last);
    // Third-party readers see parts that begin with that level.
    Imf::MultiPartInputFile file((folder / "a.exr").c_str());
    const Imath::Box2i window = file.header(0).dataWindow();
    EXPECT_EQ(window.max.x + 1, mip_level_size(c.width, first_level));
    EXPECT_EQ(window.max.y + 1, mip_level_size(c.height, first_level));
    EXPECT_EQ(Imf::TiledInputPart(file, 0).numLevels(), level_count - first_level);
  }
}

TEST(MovmfMipmapTest, LevelsAreRoundDown) {
  EXPECT_EQ(mip_level_count(1, 1), 1);
  EXPECT_EQ(mip_level_count(1, 97), 7);
  EXPECT_EQ(mip_level_count(128, 128), 8);
  EXPECT_EQ(mip_level_size(37, 1), 18);
  EXPECT_EQ(mip_level_size(37, 9), 1);
}

TEST(MovmfMipmapTest, UnknownCompressionsAreRefused) {
  const TemporaryFolder folder;
  for (const char* name : {"dwaa", "b44", "", "zip:0", "zip:10", "zip:", "zip:x", "piz:4", "none:1"}) {
    BakedWriteOptions options;
    options.compression = name;
    expect_error(ErrorCode::kUsage, {std::string("compression '") + name + "'", "none, rle, zips, zip or piz"}, [&] {
      write_movmf_mipmap(folder / "a.exr", random_mipmap(4, 4, 1, false, StorageEncoding::kFloat, 1), options);
    });
  }
  EXPECT_TRUE(folder.names().empty());
}

}  // namespace
}  // namespace multum
