// SPDX-License-Identifier: Apache-2.0
// Tests that files which are not baked files are refused. The message gives the name, the value found and the value
// expected.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <gtest/gtest.h>
#include <half.h>

#include <functional>
#include <limits>
#include <map>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "tests/unit/formats/asset/altered_file.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::random_mipmap;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

// Makes invalid baked files from a good one.
class MovmfRefusalTest : public ::testing::Test {
 protected:
  MovmfRefusalTest() {
    BakedWriteOptions options;
    options.compression = "none";
    MovmfMipmap mipmap = random_mipmap(40, 24, 4, true, StorageEncoding::kSnorm16, 2);
    quantize_movmf(mipmap, 1);
    write_movmf_mipmap(file_.good, mipmap, options);
  }

  void expect_refusal(const std::string& path, std::vector<std::string> parts) const {
    parts.push_back(path);
    expect_error(ErrorCode::kInput, parts, [&] { read_movmf_mipmap(path); });
  }

  // Makes the good file with a flat level 0, except for one value of texel (5, 3).
  std::string with_finest_texel(const std::string& channel, float value) const {
    Imf::MultiPartInputFile in(file_.good.c_str());
    std::vector<Imf::Header> headers;
    for (int part = 0; part < in.parts(); ++part) {
      headers.push_back(in.header(part));
      headers.back().erase("multum:rowChecksums");  // otherwise the checksums would report the change first
      headers.back().insert("multum:contentHash", Imf::StringAttribute(""));
    }
    Imf::MultiPartOutputFile out(file_.bad.c_str(), headers.data(), in.parts());
    for (int part = 1; part < in.parts(); ++part) {
      Imf::TiledInputPart from(in, part);
      Imf::TiledOutputPart(out, part).copyPixels(from);
    }
    std::map<std::string, std::vector<float>> floats;
    std::map<std::string, std::vector<half>> halfs;
    Imf::FrameBuffer buffer;
    for (auto it = headers[0].channels().begin(); it != headers[0].channels().end(); ++it) {
      const bool is_half = it.channel().type == Imf::HALF;
      const float changed = it.name() == channel ? value : 0.0f;
      floats[it.name()].resize(40 * 24);
      halfs[it.name()].resize(40 * 24);
      floats[it.name()][40 * 3 + 5] = changed;
      halfs[it.name()][40 * 3 + 5] = half(changed);
      const std::size_t size = is_half ? sizeof(half) : sizeof(float);
      buffer.insert(it.name(), Imf::Slice(it.channel().type,
                                          is_half ? reinterpret_cast<char*>(halfs[it.name()].data())
                                                  : reinterpret_cast<char*>(floats[it.name()].data()),
                                          size, 40 * size));
    }
    Imf::TiledOutputPart to(out, 0);
    to.setFrameBuffer(buffer);
    to.writeTiles(0, to.numXTiles() - 1, 0, to.numYTiles() - 1);
    return file_.bad;
  }

  const testing::AlteredFile file_;
  const std::vector<int> all_ = {0, 1, 2, 3, 4, 5, 6, 7, 8};  // the finest level, four lobes, four colours
};

TEST_F(MovmfRefusalTest, TheGoodFileIsRead) { EXPECT_NO_THROW(read_movmf_mipmap(file_.good)); }

TEST_F(MovmfRefusalTest, NoFileNoExrNoBake) {
  expect_refusal(file_.folder / "none.exr", {"none.exr"});
  write_bytes(file_.bad, "not an image at all");
  expect_refusal(file_.bad, {"baked file", "not an OpenEXR file"});
  write_bytes(file_.bad, "");
  expect_refusal(file_.bad, {"not an OpenEXR file"});
  expect_refusal(file_.folder.path(), {});
  expect_refusal(file_.rebuilt(all_, [](Imf::Header& h) { h.erase("multum:representation"); }),
                 {"no attribute multum:representation", "'multum bake'"});
}

TEST_F(MovmfRefusalTest, TruncatedAnywhere) {
  const std::string bytes = read_bytes(file_.good);
  for (const std::size_t size : {std::size_t{5}, std::size_t{100}, bytes.size() / 20, bytes.size() / 3,
                                 bytes.size() / 2, bytes.size() - 4000, bytes.size() - 1}) {
    SCOPED_TRACE(size);
    write_bytes(file_.bad, bytes.substr(0, size));
    expect_refusal(file_.bad, {"baked file"});
  }
}

TEST_F(MovmfRefusalTest, AttributesOfAnotherMeaning) {
  expect_refusal(file_.replaced("snorm16", "snorm17"), {"encoding", "'snorm17'", "snorm16, half or float"});
  expect_refusal(file_.replaced("movmf", "sharm"), {"representation", "'sharm'", "'movmf'"});
  expect_refusal(file_.replaced("clamp,mirror", "clamp,mirrox"), {"wrap mode", "'mirrox'", "black, clamp"});
  const auto set_int = [&](const char* name, int value) {
    return file_.rebuilt(all_, [=](Imf::Header& h) { h.insert(name, Imf::IntAttribute(value)); });
  };
  for (const char* version : {"1", "2", "5"})
    expect_refusal(set_int("multum:formatVersion", std::stoi(version)),
                   {std::string("found format version ") + version, "expected version 3 or 4"});
  expect_refusal(set_int("multum:formatVersion", 4), {"no attribute", "multum:weightCount"});
  expect_refusal(set_int("multum:lobeCount", 0), {"0 lobes", "1 to 8"});
  expect_refusal(set_int("multum:lobeCount", 9), {"9 lobes", "1 to 8"});
  expect_refusal(set_int("multum:lobeCount", 5), {"9 parts", "expected 11"});
  expect_refusal(set_int("multum:hasColours", 0), {"9 parts", "expected 5"});
  expect_refusal(file_.rebuilt(all_,
                               [](Imf::Header& h) {
                                 h.erase("multum:encoding");
                                 h.insert("multum:encoding", Imf::IntAttribute(1));
                               }),
                 {"no attribute multum:encoding"});
}

// A map of 40 x 24 texels has six levels.
TEST_F(MovmfRefusalTest, FirstLevelsThatDoNotFit) {
  const auto set_int = [&](const char* name, int value) {
    return file_.rebuilt(all_, [=](Imf::Header& h) { h.insert(name, Imf::IntAttribute(value)); });
  };
  EXPECT_NO_THROW(read_movmf_mipmap(file_.rebuilt(all_, [](Imf::Header&) {})));
  for (const char* name : {"multum:firstLevel", "multum:mapWidth", "multum:mapHeight", "multum:measuredError"})
    expect_refusal(file_.rebuilt(all_, [=](Imf::Header& h) { h.erase(name); }),
                   {std::string("found no attribute ") + name});
  expect_refusal(set_int("multum:firstLevel", -1), {"found first level -1", "expected 0 to 5"});
  expect_refusal(set_int("multum:firstLevel", 6), {"found first level 6", "expected 0 to 5"});
  expect_refusal(set_int("multum:firstLevel", 1), {"found 9 parts", "expected 8"});
  expect_refusal(set_int("multum:mapWidth", 41), {"part finest with a data window from (0, 0) to (39, 23)",
                                                  "expected (0, 0) to (40, 23), level 0 of a map of 41 x 24"});
  expect_refusal(set_int("multum:mapHeight", 0), {"found a map of 40 x 0", "expected 1 to 1048576 texels per side"});
  expect_refusal(set_int("multum:mapHeight", 2000000000), {"found a map of 40 x 2000000000"});
}

TEST_F(MovmfRefusalTest, PartsMissingOrInAnotherOrder) {
  expect_refusal(file_.rebuilt({0, 1, 2, 3, 5, 6, 7, 8}, [](Imf::Header&) {}), {"found 8 parts", "expected 9"});
  expect_refusal(file_.rebuilt({0, 2, 1, 3, 4, 5, 6, 7, 8}, [](Imf::Header&) {}),
                 {"part 1 named 'lobe.1'", "expected 'lobe.0'"});
}

TEST_F(MovmfRefusalTest, ChannelsAndLevelsOfAnotherKind) {
  const auto change_lobe_1 = [&](const std::function<void(Imf::Header&)>& change) {
    return file_.rebuilt(all_, [=](Imf::Header& h) {
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
  // Pixels cannot be copied to a part with another compression, so the channels change too. The level mode is checked
  // first.
  const auto change_tiles = [&](const char* name, Imf::LevelMode mode) {
    return file_.rebuilt(all_, [=](Imf::Header& h) {
      if (h.name() != name) return;
      h.channels().insert("x", Imf::Channel(Imf::HALF));
      h.setTileDescription(Imf::TileDescription(64, 64, mode));
    });
  };
  expect_refusal(change_tiles("lobe.1", Imf::ONE_LEVEL), {"part lobe.1 without ROUND_DOWN mip levels"});
  expect_refusal(change_tiles("finest", Imf::MIPMAP_LEVELS), {"part finest without tiles of one level"});
  expect_refusal(change_lobe_1([](Imf::Header& h) {
                   h.channels().insert("x", Imf::Channel(Imf::HALF));
                   h.dataWindow().max.x -= 1;
                 }),
                 {"part lobe.1 with a data window from (0, 0) to (18, 11)",
                  "expected (0, 0) to (19, 11), level 1 of a map of 40 x 24"});
}

// The decoder finds values that none of our writers makes.
TEST_F(MovmfRefusalTest, FinestTexelsThatMeanNothing) {
  EXPECT_NO_THROW(read_movmf_mipmap(with_finest_texel("finest.normalX.X", -1.0f)));
  for (const float lobe : {-1.0f, 0.5f, 4.0f, 1000.0f, std::numeric_limits<float>::quiet_NaN()})
    expect_refusal(with_finest_texel("finest.lobe.X", lobe), {"level 0, texel (5, 3): found lobe", "expected 0 to 3"});
  for (const float x : {1.01f, -2.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()})
    for (const char* channel : {"finest.normalX.X", "finest.normalY.X"})
      expect_refusal(with_finest_texel(channel, x),
                     {"level 0, texel (5, 3): found a normal (", "expected components of -1 to 1"});
}

}  // namespace
}  // namespace multum
