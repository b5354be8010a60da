// SPDX-License-Identifier: Apache-2.0
// Tests baked files with a damaged chunk. A reader gets either all of the baked data or an error that names the damaged
// place.
#include <ImfChannelList.h>
#include <ImfHeader.h>
#include <ImfStringAttribute.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "host/formats/asset/averages/moment_file.h"
#include "host/formats/asset/averages/sh_file.h"
#include "host/formats/asset/baked_reader.h"
#include "host/formats/asset/lobes/movmf_parts.h"
#include "host/formats/asset/lobes/movmf_reader.h"
#include "host/formats/asset/lobes/movmf_verify.h"
#include "host/formats/asset/row_checksums.h"
#include "host/foundation/base/files/exr_chunks.h"
#include "tests/unit/formats/asset/altered_file.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::random_mipmap;
using testing::read_bytes;
using testing::write_bytes;

constexpr std::size_t kTableEntry = 8, kSizeBytes = 4, kHeadBytes = 24;  // part, tile x, y, level x, y, size

std::string number_bytes(std::int64_t value, std::size_t bytes) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i) text += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 255);
  return text;
}

// Makes a good file of 40 x 24 texels with tiles of 16 x 16 texels, and makes bad files from it.
class DamagedChunkTest : public ::testing::TestWithParam<const char*> {
 protected:
  DamagedChunkTest() {
    BakedWriteOptions options;
    options.compression = GetParam();
    options.tile_size = 16;
    MovmfMipmap mipmap = random_mipmap(40, 24, 2, true, StorageEncoding::kSnorm16, 2);
    quantize_movmf(mipmap, 1);
    write_movmf_mipmap(file_.good, mipmap, options);
    chunks_ = std::make_unique<ExrChunks>(file_.good);
    bytes_ = read_bytes(file_.good);
  }

  const ExrChunkPlace& place(std::size_t part, std::size_t chunk) const { return chunks_->parts()[part].chunks[chunk]; }
  std::size_t data_at(std::size_t part, std::size_t chunk) const {
    return static_cast<std::size_t>(place(part, chunk).position);
  }

  void put(std::size_t at, const std::string& replacement) {
    std::string bytes = bytes_;
    bytes.replace(at, replacement.size(), replacement);
    write_bytes(file_.bad, bytes);
  }
  void put_size(std::size_t part, std::size_t chunk, std::int64_t size) {
    put(data_at(part, chunk) - kSizeBytes, number_bytes(size, kSizeBytes));
  }
  void put_offset(std::size_t part, std::size_t chunk, std::int64_t offset) {
    const std::string entry = number_bytes(static_cast<std::int64_t>(data_at(part, chunk) - kHeadBytes), kTableEntry);
    put(bytes_.find(entry), number_bytes(offset, kTableEntry));
  }

  void expect_refusal(std::vector<std::string> parts) const {
    parts.push_back(file_.bad);
    expect_error(ErrorCode::kInput, parts, [&] { read_movmf_mipmap(file_.bad); });
    expect_error(ErrorCode::kInput, parts, [&] { verify_movmf(file_.bad, 2); });
  }

  const testing::AlteredFile file_;
  std::unique_ptr<ExrChunks> chunks_;
  std::string bytes_;
};

INSTANTIATE_TEST_SUITE_P(Compressions, DamagedChunkTest, ::testing::Values("none", "rle", "zips", "zip:1", "piz"));

// The parts are the finest level, two lobes and two colours. In part 1, chunk 2 is tile (0, 0) of level 2, since level
// 1 has two tiles.
constexpr char kPlace[] = "part lobe.0, level 2, tile (0, 0)";

TEST_P(DamagedChunkTest, SizesThatCannotBe) {
  for (const std::int64_t size : {std::int64_t{0}, std::int64_t{-1}, std::int64_t{std::numeric_limits<int>::max()},
                                  std::int64_t{std::numeric_limits<int>::min()}, chunks_->unpacked_bytes(1, 2) + 1}) {
    SCOPED_TRACE(size);
    put_size(1, 2, size);
    expect_refusal({"damaged", kPlace, "copy or write it again"});
    expect_error(ErrorCode::kInput, {kPlace}, [&] { read_baked_header(file_.bad); });
  }
}

TEST_P(DamagedChunkTest, SizesThatAreTooShort) {
  for (const std::int64_t less : {1, 2, 7}) {
    SCOPED_TRACE(less);
    put_size(1, 2, place(1, 2).size - less);
    if (chunks_->can_unpack(1)) expect_refusal({"damaged", kPlace});
    else expect_error(ErrorCode::kInput, {"part lobe.0, level 2"}, [&] { read_movmf_mipmap(file_.bad); });
  }
}

TEST_P(DamagedChunkTest, OffsetsOfNoTile) {
  const auto here = static_cast<std::int64_t>(data_at(1, 2) - kHeadBytes);
  const auto other = static_cast<std::int64_t>(data_at(2, 2) - kHeadBytes);
  for (const std::int64_t offset :
       {std::int64_t{0}, std::int64_t{8}, other, here + 1, static_cast<std::int64_t>(bytes_.size()) - 1,
        std::numeric_limits<std::int64_t>::min(), std::int64_t{-1}}) {
    SCOPED_TRACE(offset);
    put_offset(1, 2, offset);
    expect_refusal({"damaged", kPlace});
  }
}

TEST_P(DamagedChunkTest, ATileThatIsSaidToBeAnother) {
  put(data_at(1, 2) - kHeadBytes, number_bytes(2, 4));  // the number of another part
  expect_refusal({kPlace, "another chunk is in its place"});
  put(data_at(1, 2) - 8, number_bytes(3, 4));  // the number of another level
  expect_refusal({kPlace, "another chunk is in its place"});
}

// A chunk is hidden inside another chunk. The hidden chunk's head is valid, and its bytes are within the file.
TEST_P(DamagedChunkTest, ChunksThatOverlap) {
  const std::size_t size = static_cast<std::size_t>(place(0, 0).size);
  if (size < 3 * kHeadBytes) GTEST_SKIP() << "the finest tile is too small to hide a chunk";
  std::string bytes = bytes_;
  const std::size_t at = data_at(0, 0) + kHeadBytes;
  const std::string entry = number_bytes(static_cast<std::int64_t>(data_at(1, 2) - kHeadBytes), kTableEntry);
  const std::string head_and_data =
      bytes.substr(data_at(1, 2) - kHeadBytes, kHeadBytes + static_cast<std::size_t>(place(1, 2).size));
  if (head_and_data.size() + kHeadBytes > size) GTEST_SKIP() << "the finest tile is too small to hide a chunk";
  bytes.replace(bytes.find(entry), kTableEntry, number_bytes(static_cast<std::int64_t>(at), kTableEntry));
  bytes.replace(at, head_and_data.size(), head_and_data);
  write_bytes(file_.bad, bytes);
  expect_refusal({kPlace, "overlaps another chunk"});
}

// Damages the bytes of a chunk, one at a time. Every reader must get an error or unchanged data.
TEST_P(DamagedChunkTest, BytesWithinChunks) {
  const MovmfMipmap good = read_movmf_mipmap(file_.good);
  const std::string hash = movmf_content_hash(good, 1);
  for (const auto& [part, level] : {std::pair<std::size_t, int>{0, 0}, {1, 1}, {2, 3}, {4, 5}}) {
    const std::size_t chunk =
        level == 0 ? 3 : chunks_->parts()[part].levels[static_cast<std::size_t>(level - 1)].first_chunk;
    const auto size = static_cast<std::size_t>(place(part, chunk).size);
    for (std::size_t i = 0; i < size; i += 1 + size / 13) {
      SCOPED_TRACE(std::to_string(part) + " " + std::to_string(i));
      const std::size_t at = data_at(part, chunk) + i;
      put(at, std::string(1, static_cast<char>(bytes_[at] ^ 0x41)));
      try {
        EXPECT_EQ(movmf_content_hash(read_movmf_mipmap(file_.bad), 1), hash);
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kInput);
        testing::expect_says(
            error.what(), {file_.bad, "part " + chunks_->parts()[part].name, "level " + std::to_string(level), "tile"});
      }
    }
  }
}

// A reader that reads only some rows notices damage in these rows, and reads undamaged rows.
TEST_P(DamagedChunkTest, RowsThatAreNotReadMayBeDamaged) {
  const std::size_t at = data_at(0, 4) + static_cast<std::size_t>(place(0, 4).size) / 2;  // tile (1, 1) of level 0
  put(at, std::string(1, static_cast<char>(bytes_[at] ^ 0x41)));
  MovmfReader reader(file_.bad, 1);
  EXPECT_NO_THROW(reader.read_finest(0, 16));
  expect_error(ErrorCode::kInput, {file_.bad, "part finest, level 0"}, [&] { reader.read_finest(16, 8); });
  expect_error(ErrorCode::kInput, {file_.bad, "part finest, level 0"}, [&] { reader.read_finest(15, 2); });
}

// The reader must write every value. The buffers first contain a pattern that no file contains.
TEST_P(DamagedChunkTest, NothingOfABufferStaysAsItWas) {
  const MovmfMipmap header = read_movmf_header(file_.good);
  const std::vector<MovmfPart> parts = movmf_parts(header);
  BakedReader reader(file_.good, 2);
  reader.expect(full_header(header), {parts.begin(), parts.end()});
  for (std::size_t p = 0; p < parts.size(); ++p)
    for (int l = parts[p].first_level; l < parts[p].first_level + parts[p].level_count; ++l) {
      const int width = mip_level_size(40, l), height = mip_level_size(24, l);
      const std::size_t count = texel_count(width, height) * parts[p].channels.size();
      std::vector<float> first(count, std::numeric_limits<float>::quiet_NaN()), second(count, -1e30f);
      reader.read_values(p, l, 0, height, first.data());
      reader.read_values(p, l, 0, height, second.data());
      EXPECT_EQ(std::memcmp(first.data(), second.data(), count * sizeof(float)), 0) << p << " " << l;
    }
}

TEST_P(DamagedChunkTest, EveryChunkFillsPoisonedMemoryOrIsRefused) {
  if (!chunks_->can_unpack(1)) GTEST_SKIP() << "the library unpacks it";
  const auto unpacked = [&](const std::string& path, unsigned char poison) {
    std::string all;
    const ExrChunks chunks(path);
    for (std::size_t chunk = 0; chunk < chunks.parts()[1].chunks.size(); ++chunk) {
      std::vector<unsigned char> memory(1 << 16, poison);
      chunks.unpack(1, chunk, memory);
      all.append(memory.begin(), memory.begin() + static_cast<std::ptrdiff_t>(chunks.unpacked_bytes(1, chunk)));
    }
    return all;
  };
  EXPECT_EQ(unpacked(file_.good, 0xA5), unpacked(file_.good, 0x5A));
  for (std::size_t i = 0; i < static_cast<std::size_t>(place(1, 0).size); i += 3) {
    const std::size_t at = data_at(1, 0) + i;
    put(at, std::string(1, static_cast<char>(bytes_[at] ^ 0x11)));
    try {
      EXPECT_EQ(unpacked(file_.bad, 0xA5), unpacked(file_.bad, 0x5A)) << i;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
    }
  }
}

// Files of earlier versions have one checksum for all rows. It is compared before the first rows are returned.
TEST_P(DamagedChunkTest, FilesWithoutChecksumsOfRows) {
  const auto without = [](Imf::Header& header) { header.erase(kRowChecksumsAttribute); };
  EXPECT_NO_THROW(read_movmf_mipmap(file_.rebuilt({0, 1, 2, 3, 4}, without)));
  const std::string bad_hash(kContentHashDigits, '7');
  const std::string path = file_.rebuilt({0, 1, 2, 3, 4}, [&](Imf::Header& header) {
    without(header);
    header.insert(kContentHashAttribute, Imf::StringAttribute(bad_hash));
  });
  expect_error(ErrorCode::kInput, {path, "damaged", "found checksum", bad_hash}, [&] { read_movmf_mipmap(path); });
  MovmfReader reader(path, 1);
  expect_error(ErrorCode::kInput, {path, "found checksum"}, [&] { reader.read_finest(0, 1); });
}

TEST(RowChecksums, FilesWithTilesOfAnotherSizeHaveNone) {
  const BakedHeader header = [] {
    BakedHeader made;
    made.width = made.height = 200;
    return made;
  }();
  const std::vector<BakedPart> parts = {mean_colour_part(header)};
  RowChecksums of_128(header, parts, 128), of_100(header, parts, 100);
  EXPECT_EQ(of_128.text().size(), of_100.text().size());
  EXPECT_FALSE(of_100.take(of_128.text()));
  const std::vector<float> values(600, 0.5f);
  of_128.set(0, 1, 0, values.data(), values.size());
  RowChecksums other(header, parts, 128);
  EXPECT_TRUE(other.take(of_128.text()));
  EXPECT_TRUE(other.is_same(0, 1, 0, values.data(), values.size()));
  EXPECT_FALSE(other.is_same(0, 1, 0, values.data(), values.size() - 1));
  EXPECT_FALSE(other.is_same(0, 2, 0, values.data(), values.size()));
}

}  // namespace
}  // namespace multum
