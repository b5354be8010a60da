// SPDX-License-Identifier: Apache-2.0
// The baked file: what is written is read, bit for bit; what is no baked file is refused with its name, what was found
// and what was expected.
#include "host/asset/movmf_mipmap.h"

#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/unit/movmf_test_mipmap.h"
#include "tests/unit/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::random_mipmap;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

void expect_same_bits(const MovmfMipmap& found, const MovmfMipmap& expected) {
  ASSERT_EQ(found.levels.size(), expected.levels.size());
  for (std::size_t l = 0; l < expected.levels.size(); ++l) {
    const MovmfLevel &a = found.levels[l], &b = expected.levels[l];
    ASSERT_EQ(a.width, b.width);
    ASSERT_EQ(a.height, b.height);
    ASSERT_EQ(a.lobes.size(), b.lobes.size());
    ASSERT_EQ(a.colours.size(), b.colours.size());
    for (std::size_t j = 0; j < b.lobes.size(); ++j) {
      ASSERT_EQ(a.lobes[j].size(), b.lobes[j].size());
      EXPECT_EQ(std::memcmp(a.lobes[j].data(), b.lobes[j].data(), b.lobes[j].size() * sizeof(glm::vec4)), 0)
          << "level " << l << ", lobe " << j;
    }
    for (std::size_t j = 0; j < b.colours.size(); ++j) {
      ASSERT_EQ(a.colours[j].size(), b.colours[j].size());
      EXPECT_EQ(std::memcmp(a.colours[j].data(), b.colours[j].data(), b.colours[j].size() * sizeof(glm::vec3)), 0)
          << "level " << l << ", colour " << j;
    }
  }
}

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
      MovmfWriteOptions options;
      options.compression = compression;
      write_movmf_mipmap(folder / "a.ndf.exr", mipmap, options);
      const MovmfMipmap found = read_movmf_mipmap(folder / "a.ndf.exr");
      expect_same_bits(found, mipmap);
      EXPECT_EQ(found.encoding, encoding);
      EXPECT_EQ(found.wrap_s, mipmap.wrap_s);
      EXPECT_EQ(found.wrap_t, mipmap.wrap_t);
      EXPECT_EQ(found.provenance.software, mipmap.provenance.software);
      EXPECT_EQ(found.provenance.source_name, mipmap.provenance.source_name);
      EXPECT_EQ(found.provenance.source_hash, mipmap.provenance.source_hash);
      EXPECT_EQ(found.provenance.settings, mipmap.provenance.settings);
      EXPECT_EQ(found.provenance.settings_hash, mipmap.provenance.settings_hash);
      EXPECT_EQ(found.provenance.measured_error, mipmap.provenance.measured_error);
      EXPECT_EQ(found.provenance.content_hash, movmf_content_hash(mipmap, 1));
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
  MovmfWriteOptions options;
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
    quantize_movmf(dropped, 1);  // levels without texels are passed over, the others on their grid already
    write_movmf_mipmap(folder / "a.exr", dropped, {});
    const MovmfMipmap found = read_movmf_mipmap(folder / "a.exr");
    EXPECT_EQ(found.first_level, first_level);
    EXPECT_EQ(found.width(), c.width);
    EXPECT_EQ(found.height(), c.height);
    EXPECT_EQ(found.lobe_count(), c.lobes);
    EXPECT_EQ(found.has_colours(), c.colours);
    expect_same_bits(found, dropped);
    for (int l = 0; l < level_count; ++l)
      EXPECT_EQ(found.levels[static_cast<std::size_t>(l)].lobes[0].empty(), l < first_level) << l;
    EXPECT_EQ(found.provenance.content_hash, movmf_content_hash(dropped, 2));
    EXPECT_NE(found.provenance.content_hash, hash) << "a level less, another checksum";
    hash = found.provenance.content_hash;
    const MovmfMipmap header = read_movmf_header(folder / "a.exr");
    EXPECT_EQ(header.first_level, first_level);
    EXPECT_EQ(header.width(), c.width);
    const std::string last = std::to_string(level_count - 1), first = std::to_string(first_level);
    EXPECT_EQ(levels_text(header), (first == last ? "level " : "levels " + first + " to ") + last + " of 0 to " + last);
    // For strangers: the parts begin with that level.
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
    MovmfWriteOptions options;
    options.compression = name;
    expect_error(ErrorCode::kUsage, {std::string("compression '") + name + "'", "none, rle, zips, zip or piz"}, [&] {
      write_movmf_mipmap(folder / "a.exr", random_mipmap(4, 4, 1, false, StorageEncoding::kFloat, 1), options);
    });
  }
  EXPECT_TRUE(folder.names().empty());
}

// Files that are no baked file: made from a good one.
class MovmfRefusalTest : public ::testing::Test {
 protected:
  MovmfRefusalTest() {
    MovmfWriteOptions options;
    options.compression = "none";
    write_movmf_mipmap(good_, random_mipmap(40, 24, 4, true, StorageEncoding::kSnorm16, 2), options);
  }

  void expect_refusal(const std::string& path, std::vector<std::string> parts) const {
    parts.push_back(path);
    expect_error(ErrorCode::kInput, parts, [&] { read_movmf_mipmap(path); });
  }

  // Every `from` in the good file's bytes becomes `to`, of the same length.
  std::string replaced(const std::string& from, const std::string& to) const {
    std::string bytes = read_bytes(good_);
    EXPECT_EQ(from.size(), to.size());
    std::size_t count = 0;
    for (std::size_t at = bytes.find(from); at != std::string::npos; at = bytes.find(from, at + 1), ++count)
      bytes.replace(at, to.size(), to);
    EXPECT_GT(count, 0u) << from;
    write_bytes(bad_, bytes);
    return bad_;
  }

  // The good file with its parts chosen by `order` and its headers changed.
  std::string rebuilt(const std::vector<int>& order, const std::function<void(Imf::Header&)>& change) const {
    Imf::MultiPartInputFile in(good_.c_str());
    std::vector<Imf::Header> headers;
    for (const int part : order) {
      headers.push_back(in.header(part));
      change(headers.back());
    }
    Imf::MultiPartOutputFile out(bad_.c_str(), headers.data(), static_cast<int>(headers.size()));
    for (std::size_t i = 0; i < order.size(); ++i) {
      Imf::TiledInputPart from(in, order[i]);
      Imf::TiledOutputPart to(out, static_cast<int>(i));
      if (headers[i].channels() == in.header(order[i]).channels()) to.copyPixels(from);
    }
    return bad_;
  }

  const TemporaryFolder folder_;
  const std::string good_ = folder_ / "good.exr", bad_ = folder_ / "bad.exr";
  const std::vector<int> all_ = {0, 1, 2, 3, 4, 5, 6, 7};
};

TEST_F(MovmfRefusalTest, TheGoodFileIsRead) { EXPECT_NO_THROW(read_movmf_mipmap(good_)); }

TEST_F(MovmfRefusalTest, NoFileNoExrNoBake) {
  expect_refusal(folder_ / "none.exr", {"none.exr"});
  write_bytes(bad_, "not an image at all");
  expect_refusal(bad_, {"not a readable baked file"});
  write_bytes(bad_, "");
  expect_refusal(bad_, {});
  expect_refusal(folder_.path(), {});
  expect_refusal(rebuilt(all_, [](Imf::Header& h) { h.erase("multum:representation"); }),
                 {"no attribute multum:representation", "'multum bake'"});
}

TEST_F(MovmfRefusalTest, TruncatedAnywhere) {
  const std::string bytes = read_bytes(good_);
  for (const std::size_t size : {std::size_t{5}, std::size_t{100}, bytes.size() / 20, bytes.size() / 3,
                                 bytes.size() / 2, bytes.size() - 4000, bytes.size() - 1}) {
    SCOPED_TRACE(size);
    write_bytes(bad_, bytes.substr(0, size));
    expect_refusal(bad_, {"not a readable baked file"});
  }
}

TEST_F(MovmfRefusalTest, AttributesOfAnotherMeaning) {
  expect_refusal(replaced("snorm16", "snorm17"), {"found encoding 'snorm17'", "expected snorm16, half or float"});
  expect_refusal(replaced("movmf", "sharm"), {"found representation 'sharm'", "expected 'movmf'"});
  expect_refusal(replaced("clamp,mirror", "clamp,mirrox"), {"found wrap mode 'mirrox'", "expected black, clamp"});
  const auto set_int = [&](const char* name, int value) {
    return rebuilt(all_, [=](Imf::Header& h) { h.insert(name, Imf::IntAttribute(value)); });
  };
  expect_refusal(set_int("multum:formatVersion", 3), {"found format version 3", "expected version 1 or 2"});
  expect_refusal(set_int("multum:lobeCount", 0), {"found 0 lobes", "expected 1 to 8"});
  expect_refusal(set_int("multum:lobeCount", 9), {"found 9 lobes", "expected 1 to 8"});
  expect_refusal(set_int("multum:lobeCount", 5), {"found 8 parts", "expected 10"});
  expect_refusal(set_int("multum:hasColours", 0), {"found 8 parts", "expected 4"});
  expect_refusal(rebuilt(all_,
                         [](Imf::Header& h) {
                           h.erase("multum:encoding");
                           h.insert("multum:encoding", Imf::IntAttribute(1));
                         }),
                 {"no attribute multum:encoding"});
}

// 40 x 24: six levels. Version 2 says which of them is the first.
TEST_F(MovmfRefusalTest, FirstLevelsThatDoNotFit) {
  const auto version_2 = [&](const std::function<void(Imf::Header&)>& change) {
    return rebuilt(all_, [&](Imf::Header& h) {
      h.insert("multum:formatVersion", Imf::IntAttribute(2));
      change(h);
    });
  };
  const auto set_int = [&](const char* name, int value) {
    return version_2([=](Imf::Header& h) { h.insert(name, Imf::IntAttribute(value)); });
  };
  EXPECT_NO_THROW(read_movmf_mipmap(version_2([](Imf::Header&) {})));
  for (const char* name : {"multum:firstLevel", "multum:mapWidth", "multum:mapHeight"})
    expect_refusal(version_2([=](Imf::Header& h) { h.erase(name); }), {std::string("found no attribute ") + name});
  expect_refusal(set_int("multum:firstLevel", -1), {"found first level -1", "expected 0 to 5"});
  expect_refusal(set_int("multum:firstLevel", 6), {"found first level 6", "expected 0 to 5"});
  expect_refusal(set_int("multum:firstLevel", 1),
                 {"found a data window of 40 x 24", "expected 20 x 12, level 1 of a map of 40 x 24"});
  expect_refusal(set_int("multum:mapWidth", 41), {"found a data window of 40 x 24", "expected 41 x 24"});
  expect_refusal(set_int("multum:mapHeight", 0), {"found a map of 40 x 0", "expected 1 to 1048576 texels a side"});
  expect_refusal(set_int("multum:mapHeight", 2000000000), {"found a map of 40 x 2000000000"});
}

// As they were written before there were first levels.
TEST_F(MovmfRefusalTest, FilesOfVersion1NeedNotNameTheFirstLevel) {
  const std::string path = rebuilt(all_, [](Imf::Header& h) {
    for (const char* name : {"multum:firstLevel", "multum:mapWidth", "multum:mapHeight"}) h.erase(name);
  });
  const MovmfMipmap mipmap = read_movmf_mipmap(path);
  EXPECT_EQ(mipmap.first_level, 0);
  EXPECT_EQ(mipmap.width(), 40);
  EXPECT_EQ(levels_text(mipmap), "6 levels");
}

TEST_F(MovmfRefusalTest, PartsMissingOrInAnotherOrder) {
  expect_refusal(rebuilt({0, 1, 2, 4, 5, 6, 7}, [](Imf::Header&) {}), {"found 7 parts", "expected 8"});
  expect_refusal(rebuilt({1, 0, 2, 3, 4, 5, 6, 7}, [](Imf::Header&) {}),
                 {"part 0 named 'lobe.1'", "expected 'lobe.0'"});
}

TEST_F(MovmfRefusalTest, ChannelsAndLevelsOfAnotherKind) {
  const auto change_lobe_1 = [&](const std::function<void(Imf::Header&)>& change) {
    return rebuilt(all_, [=](Imf::Header& h) {
      if (h.name() == "lobe.1") change(h);
    });
  };
  expect_refusal(change_lobe_1([](Imf::Header& h) { h.channels().insert("lobe1.vMF.A", Imf::Channel(Imf::HALF)); }),
                 {"channel lobe1.vMF.A of another pixel type", "expected float for encoding snorm16"});
  expect_refusal(change_lobe_1([](Imf::Header& h) {
                   Imf::ChannelList channels;
                   channels.insert("R", Imf::Channel(Imf::FLOAT));
                   h.channels() = channels;
                 }),
                 {"no channel lobe1.vMF.R in part lobe.1"});
  // Another compression copies no pixels, so change the channels too: the level mode is looked at first.
  expect_refusal(change_lobe_1([](Imf::Header& h) {
                   h.channels().insert("x", Imf::Channel(Imf::HALF));
                   h.setTileDescription(Imf::TileDescription(64, 64, Imf::ONE_LEVEL));
                 }),
                 {"part lobe.1 without ROUND_DOWN mip levels"});
  expect_refusal(change_lobe_1([](Imf::Header& h) {
                   h.channels().insert("x", Imf::Channel(Imf::HALF));
                   h.dataWindow().max.x -= 1;
                 }),
                 {"part lobe.1 of another size"});
}

}  // namespace
}  // namespace multum
