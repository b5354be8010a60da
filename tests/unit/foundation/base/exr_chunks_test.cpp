// SPDX-License-Identifier: Apache-2.0
// Tests chunks of OpenEXR files of every layout, written by the library.
#include "host/foundation/base/files/exr_chunks.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cstring>

#include "host/foundation/base/files/exr_unpack.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

constexpr Imf::Compression kCompressions[] = {Imf::NO_COMPRESSION,  Imf::RLE_COMPRESSION,  Imf::ZIPS_COMPRESSION,
                                              Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION,  Imf::PXR24_COMPRESSION,
                                              Imf::B44_COMPRESSION, Imf::DWAA_COMPRESSION, Imf::DWAB_COMPRESSION};

class ExrChunksTest : public ::testing::Test {
 protected:
  static float value_at(int x, int y) { return static_cast<float>(x / 4) * 0.25f + static_cast<float>(y / 3); }

  // Writes rows of Y, and of RY for every other texel in both directions, in a window that does not begin at 0.
  std::string rows_file(Imf::Compression compression, Imf::LineOrder order) const {
    const Imath::Box2i window({-4, 6}, {63, 45});
    Imf::Header header(window, window);
    header.compression() = compression;
    header.lineOrder() = order;
    header.channels().insert("RY", Imf::Channel(Imf::HALF, 2, 2));
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    std::vector<float> luma;
    for (int y = 6; y <= 45; ++y)
      for (int x = -4; x <= 63; ++x) luma.push_back(value_at(x, y));
    std::vector<std::uint16_t> chroma(34 * 20, 0x3c00);
    Imf::FrameBuffer frame;
    frame.insert("Y", Imf::Slice::Make(Imf::FLOAT, luma.data(), window));
    frame.insert("RY", Imf::Slice::Make(Imf::HALF, chroma.data(), window, 2, 68, 2, 2));
    Imf::OutputFile out(path_.c_str(), header);
    out.setFrameBuffer(frame);
    out.writePixels(40);
    return path_;
  }

  std::string tiles_file(Imf::Compression compression, Imf::LevelMode mode, Imf::LevelRoundingMode rounding) const {
    Imf::Header header(45, 26);
    header.compression() = compression;
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    header.setTileDescription(Imf::TileDescription(16, 8, mode, rounding));
    Imf::TiledOutputFile out(path_.c_str(), header);
    for (int ly = 0; ly < out.numYLevels(); ++ly)
      for (int lx = 0; lx < out.numXLevels(); ++lx) {
        if (mode != Imf::RIPMAP_LEVELS && lx != ly) continue;
        std::vector<float> values;
        for (int y = 0; y < out.levelHeight(ly); ++y)
          for (int x = 0; x < out.levelWidth(lx); ++x) values.push_back(value_at(x + 100 * lx, y + 100 * ly));
        Imf::FrameBuffer frame;
        frame.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4,
                                     4 * static_cast<std::size_t>(out.levelWidth(lx))));
        out.setFrameBuffer(frame);
        out.writeTiles(0, out.numXTiles(lx) - 1, 0, out.numYTiles(ly) - 1, lx, ly);
      }
    return path_;
  }

  const TemporaryFolder folder_;
  const std::string path_ = folder_ / "a.exr";
};

TEST_F(ExrChunksTest, RowsOfEveryCompression) {
  for (const Imf::Compression compression : kCompressions)
    for (const Imf::LineOrder order : {Imf::INCREASING_Y, Imf::DECREASING_Y}) {
      SCOPED_TRACE(compression);
      const ExrChunks chunks(rows_file(compression, order));
      const ExrPart& part = chunks.parts()[0];
      EXPECT_EQ(part.chunk_height, exr_rows_per_chunk(compression));
      EXPECT_NO_THROW(chunks.check_all(2));
      if (!chunks.can_unpack(0)) continue;
      for (std::size_t chunk = 0; chunk < part.chunks.size(); ++chunk) {
        std::vector<unsigned char> bytes;
        chunks.unpack(0, chunk, bytes);
        std::size_t at = 0;
        for (int y = chunks.area(0, chunk).y; y < chunks.area(0, chunk).y + chunks.area(0, chunk).height; ++y) {
          if (y % 2 == 0) at += 34 * 2;
          for (int x = -4; x <= 63; ++x, at += 4) {
            float value = 0.0f;
            std::memcpy(&value, bytes.data() + at, 4);
            ASSERT_EQ(value, value_at(x, y + 6));
          }
        }
        EXPECT_EQ(static_cast<std::int64_t>(at), chunks.unpacked_bytes(0, chunk));
      }
    }
}

TEST_F(ExrChunksTest, TilesOfEveryKindOfLevel) {
  for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS})
    for (const Imf::LevelRoundingMode rounding : {Imf::ROUND_DOWN, Imf::ROUND_UP})
      for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIP_COMPRESSION}) {
        SCOPED_TRACE(std::to_string(mode) + " " + std::to_string(rounding));
        const ExrChunks chunks(tiles_file(compression, mode, rounding));
        EXPECT_NO_THROW(chunks.check_all(1));
        std::vector<unsigned char> bytes;
        for (std::size_t chunk = 0; chunk < chunks.parts()[0].chunks.size(); ++chunk) {
          chunks.unpack(0, chunk, bytes);
          const ExrChunkArea is = chunks.area(0, chunk);
          for (int y = 0; y < is.height; ++y)
            for (int x = 0; x < is.width; ++x) {
              float value = 0.0f;
              std::memcpy(&value, bytes.data() + 4 * (y * is.width + x), 4);
              ASSERT_EQ(value, value_at(is.x + x + 100 * is.level_x, is.y + y + 100 * is.level_y));
            }
        }
      }
}

// In this damaged map of a user, the library would fill the missing values from uninitialised memory.
TEST_F(ExrChunksTest, ChunksThatUnpackToTooLittle) {
  for (const Imf::Compression compression : {Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION, Imf::ZIP_COMPRESSION}) {
    const ExrChunks good(rows_file(compression, Imf::INCREASING_Y));
    const ExrChunkPlace place = good.parts()[0].chunks[1];
    std::string bytes = read_bytes(path_);
    bytes.replace(static_cast<std::size_t>(place.position) - 4, 1, 1, static_cast<char>(place.size - 1));
    const std::string bad = folder_ / "bad.exr";
    write_bytes(bad, bytes);
    const int rows = exr_rows_per_chunk(compression);
    expect_error(ErrorCode::kInput, {bad, "damaged", "rows " + std::to_string(rows) + " to "},
                 [&] { ExrChunks(bad).check_all(1); });
    const ExrChunks chunks(bad);
    EXPECT_NO_THROW(chunks.check_rows(0, 0, rows, 1));
    expect_error(ErrorCode::kInput, {bad}, [&] { chunks.check_rows(0, rows, rows + 1, 1); });
  }
}

TEST(UnpackExr, RunsThatEndTooEarlyOrTooLate) {
  const auto unpack = [](std::vector<unsigned char> packed, std::size_t size) {
    std::vector<unsigned char> out(size, 0xA5);
    return unpack_exr(exr_compression::kRle, packed.data(), packed.size(), out.data(), size) == nullptr;
  };
  EXPECT_TRUE(unpack({9, 7}, 10));
  EXPECT_FALSE(unpack({8, 7}, 10));
  EXPECT_FALSE(unpack({10, 7}, 10));
  EXPECT_FALSE(unpack({9}, 10));
  EXPECT_TRUE(unpack({0xFE, 1, 2, 7, 3}, 10));
  EXPECT_FALSE(unpack({7, 3, 0xFE, 1}, 10));
  EXPECT_FALSE(unpack({}, 10));
}

TEST(UnpackExr, KnowsWhatCannotBe) {
  EXPECT_FALSE(may_unpack_exr(exr_compression::kNone, 9, 10));
  EXPECT_TRUE(may_unpack_exr(exr_compression::kNone, 10, 10));
  EXPECT_FALSE(may_unpack_exr(exr_compression::kZip, 10, 100000));
  EXPECT_TRUE(may_unpack_exr(exr_compression::kZip, 100, 100000));
  EXPECT_FALSE(may_unpack_exr(exr_compression::kRle, 10, 1000));
  EXPECT_TRUE(may_unpack_exr(exr_compression::kDwaa, 10, 1000000));
}

}  // namespace
}  // namespace multum
