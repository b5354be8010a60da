// SPDX-License-Identifier: Apache-2.0
// Tests inferred textures on disk. 16-bit floats must read back exactly, for every level and size. A message must name
// each file of another kind, and no file may reveal where it was made.
#include "host/fields/inferred/inferred_texture.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledInputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "host/foundation/base/split_mix.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::Names;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

// Returns 16-bit floats of every magnitude. The first values are special: zeros of both signs, the largest values, and
// the smallest ones.
InferredTexture random_texture(int width, int height) {
  InferredTexture texture{width, height, {}, "{\"seed\": \"" + std::to_string(width) + "\"}"};
  SplitMix64 random(static_cast<std::uint64_t>(1000 * width + height));
  const int count = 3 * MipLayout(width, height).texel_count;
  const float special[] = {0.0f, -0.0f, 65504.0f, -65504.0f, 0x1p-24f, 0x1p-14f, 1.0f};
  for (int i = 0; i < count; ++i) {
    half value;
    value.setBits(static_cast<std::uint16_t>(random.next() >> 48));
    if (!value.isFinite()) value = half(0.5f);
    texture.texels.push_back(i < 7 ? special[i] : static_cast<float>(value));
  }
  return texture;
}

class InferredTextureSizeTest : public ::testing::TestWithParam<std::pair<int, int>> {};
INSTANTIATE_TEST_SUITE_P(Sizes, InferredTextureSizeTest,
                         ::testing::Values(std::pair{1, 1}, std::pair{1, 130}, std::pair{200, 1}, std::pair{5, 3},
                                           std::pair{64, 64}, std::pair{65, 63}, std::pair{203, 77},
                                           std::pair{256, 128}));

TEST_P(InferredTextureSizeTest, EveryHalfOfEveryLevelComesBack) {
  const auto [width, height] = GetParam();
  const TemporaryFolder folder;
  const InferredTexture texture = random_texture(width, height);
  write_inferred_texture(texture, folder / "a.exr");
  EXPECT_EQ(folder.names(), Names{"a.exr"});
  const InferredTexture found = read_inferred_texture(folder / "a.exr");
  EXPECT_EQ(found.width, width);
  EXPECT_EQ(found.height, height);
  EXPECT_EQ(found.provenance, texture.provenance);
  EXPECT_EQ(read_texture_provenance(folder / "a.exr"), texture.provenance);
  ASSERT_EQ(found.texels.size(), texture.texels.size());
  EXPECT_EQ(std::memcmp(found.texels.data(), texture.texels.data(), 4 * found.texels.size()), 0) << "every bit";
}

// Reads the file with only the library, as a third party would.
TEST_P(InferredTextureSizeTest, TheFileIsAsTheFormatPageSays) {
  const auto [width, height] = GetParam();
  const TemporaryFolder folder;
  const InferredTexture texture = random_texture(width, height);
  write_inferred_texture(texture, folder / "a.exr");
  Imf::TiledInputFile file((folder / "a.exr").c_str());
  EXPECT_EQ(file.levelMode(), Imf::MIPMAP_LEVELS);
  EXPECT_EQ(file.levelRoundingMode(), Imf::ROUND_DOWN);
  EXPECT_EQ(file.header().dataWindow(), Imath::Box2i({0, 0}, {width - 1, height - 1}));
  std::string channels;
  for (auto c = file.header().channels().begin(); c != file.header().channels().end(); ++c) {
    channels += c.name();
    EXPECT_EQ(c.channel().type, Imf::HALF);
  }
  EXPECT_EQ(channels, "BGR");
  const MipLayout layout(width, height);
  ASSERT_EQ(file.numLevels(), layout.level_count());
  for (int l = 0; l < layout.level_count(); ++l) {
    const MipLevelPlace& level = layout.levels[static_cast<std::size_t>(l)];
    ASSERT_EQ(file.levelWidth(l), level.width);
    ASSERT_EQ(file.levelHeight(l), level.height);
    const std::size_t count = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
    for (std::size_t c = 0; c < 3; ++c) {
      std::vector<half> values(count, half(-77.0f));
      Imf::FrameBuffer frame;
      frame.insert(std::string(1, "RGB"[c]).c_str(),
                   Imf::Slice(Imf::HALF, reinterpret_cast<char*>(values.data()), sizeof(half),
                              sizeof(half) * static_cast<std::size_t>(level.width)));
      file.setFrameBuffer(frame);
      file.readTiles(0, file.numXTiles(l) - 1, 0, file.numYTiles(l) - 1, l);
      for (std::size_t i = 0; i < count; ++i)
        ASSERT_EQ(static_cast<float>(values[i]), texture.texels[3 * (static_cast<std::size_t>(level.offset) + i) + c]);
    }
  }
}

TEST(InferredTextureTest, OtherFloatsAreRoundedToHalfsAndStayFinite) {
  const TemporaryFolder folder;
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const InferredTexture texture{2, 1, {0.1f, 1.0f / 3.0f, 1e-12f, 65519.0f, 1e9f, -kInf, 65504.0f, kInf, -7e4f}, ""};
  write_inferred_texture(texture, folder / "a.exr");
  const InferredTexture found = read_inferred_texture(folder / "a.exr");
  EXPECT_EQ(found.texels, (std::vector<float>{static_cast<float>(half(0.1f)), static_cast<float>(half(1.0f / 3.0f)),
                                              0.0f, 65504.0f, 65504.0f, -65504.0f, 65504.0f, 65504.0f, -65504.0f}));
  EXPECT_EQ(found.provenance, "");
}

// ---- Foreign files

struct Foreign {
  Imf::LevelMode mode = Imf::MIPMAP_LEVELS;
  Imf::LevelRoundingMode rounding = Imf::ROUND_DOWN;
  std::vector<const char*> channels = {"R", "G", "B"};
  Imf::PixelType type = Imf::HALF;
  int left = 0, top = 0;
  int width = 9, height = 5;
};

// Writes zeros with only the library.
void write_foreign(const Foreign& foreign, const std::string& path) {
  const Imath::Box2i window({foreign.left, foreign.top},
                            {foreign.left + foreign.width - 1, foreign.top + foreign.height - 1});
  Imf::Header header(window, window);
  header.compression() = Imf::NO_COMPRESSION;
  for (const char* channel : foreign.channels) header.channels().insert(channel, Imf::Channel(foreign.type));
  header.setTileDescription(Imf::TileDescription(64, 64, foreign.mode, foreign.rounding));
  Imf::TiledOutputFile file(path.c_str(), header);
  const std::vector<std::uint32_t> zeros(static_cast<std::size_t>(foreign.width * foreign.height));
  Imf::FrameBuffer frame;
  for (const char* channel : foreign.channels)
    frame.insert(channel, Imf::Slice::Make(foreign.type, zeros.data(), window));
  file.setFrameBuffer(frame);
  for (int l = 0; l < file.numLevels(); ++l) file.writeTiles(0, file.numXTiles(l) - 1, 0, file.numYTiles(l) - 1, l);
}

TEST(InferredTextureRefusalTest, TiledFilesOfAnotherShape) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  const auto refuse = [&](const Foreign& foreign, std::vector<std::string> parts) {
    SCOPED_TRACE(parts.front());
    parts.push_back(path + ": ");
    write_foreign(foreign, path);
    expect_error(ErrorCode::kInput, parts, [&] { read_inferred_texture(path); });
    EXPECT_EQ(read_texture_provenance(path), "");
  };
  write_foreign({}, path);
  EXPECT_EQ(read_inferred_texture(path).texels, std::vector<float>(3 * (45 + 8 + 2 + 1)));
  EXPECT_EQ(read_texture_provenance(path), "") << "no provenance in it";
  const std::vector<std::string> shape = {"MIPMAP_LEVELS", "ROUND_DOWN"};
  refuse({.mode = Imf::ONE_LEVEL}, shape);
  refuse({.rounding = Imf::ROUND_UP}, shape);
  refuse({.channels = {"G", "B"}}, {"channel R", "R, G and B"});
  refuse({.channels = {"R", "B", "A"}}, {"channel G"});
  refuse({.channels = {"Y"}}, {"channel R"});
  refuse({.type = Imf::FLOAT}, {"channel R", "half floats"});
  for (const int shift : {-3, 7}) {
    refuse({.left = shift}, {"data window", "(0, 0)"});
    refuse({.top = shift}, {"data window", "(0, 0)"});
  }
  refuse({.width = 16385, .height = 1}, {"16385 x 1", "16384"});
}

TEST(InferredTextureRefusalTest, FilesThatAreNotTiledOrNoImages) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  const auto refuse = [&](const std::string& file) {
    expect_error(ErrorCode::kInput, {file + ": ", "tiled EXR"}, [&] { read_inferred_texture(file); });
    EXPECT_EQ(read_texture_provenance(file), "");
  };
  {
    Imf::Header header(4, 4);
    for (const char* channel : {"R", "G", "B"}) header.channels().insert(channel, Imf::Channel(Imf::HALF));
    Imf::OutputFile lines(path.c_str(), header);
    const std::vector<half> zeros(16);
    Imf::FrameBuffer frame;
    for (const char* channel : {"R", "G", "B"})
      frame.insert(channel, Imf::Slice::Make(Imf::HALF, zeros.data(), header.dataWindow()));
    lines.setFrameBuffer(frame);
    lines.writePixels(4);
  }
  refuse(path);
  write_bytes(path, "");
  refuse(path);
  write_bytes(path, "not an image");
  refuse(path);
  refuse(folder / "none.exr");
  refuse(folder.path());
}

TEST(InferredTextureRefusalTest, FilesCutShort) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  write_inferred_texture(random_texture(130, 70), path);
  const std::string bytes = read_bytes(path);
  for (std::size_t size : {std::size_t{4}, std::size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
    SCOPED_TRACE(size);
    write_bytes(path, bytes.substr(0, size));
    expect_error(ErrorCode::kInput, {path + ": ", "tiled EXR"}, [&] { read_inferred_texture(path); });
  }
  write_bytes(path, bytes.substr(0, 100));  // in the header
  EXPECT_EQ(read_texture_provenance(path), "");
}

TEST(InferredTextureTest, NothingStaysOfWhatCannotBeWritten) {
  const TemporaryFolder folder;
  const InferredTexture texture = random_texture(8, 8);
  expect_error(ErrorCode::kEnvironment, {folder / "none/a.exr", "exist"},
               [&] { write_inferred_texture(texture, folder / "none/a.exr"); });
  expect_error(ErrorCode::kUsage, {folder.path(), "folder"}, [&] { write_inferred_texture(texture, folder.path()); });
  EXPECT_EQ(folder.names(), Names{});
}

TEST(InferredTextureDeathTest, TooFewTexels) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  const TemporaryFolder folder;
  InferredTexture texture = random_texture(5, 3);
  texture.texels.pop_back();
  EXPECT_DEATH(write_inferred_texture(texture, folder / "a.exr"), "texel_count");
}

}  // namespace
}  // namespace multum
