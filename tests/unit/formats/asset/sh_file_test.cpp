// SPDX-License-Identifier: Apache-2.0
// Tests baked files of spherical harmonics: rounding, writing, reading, refusal, and verification.
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/averages/sh_file.h"
#include "host/formats/asset/averages/sh_verify.h"
#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/lab/reference/spherical_harmonics.h"
#include "tests/unit/formats/asset/altered_file.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::random_direction;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::uniform;
using testing::write_bytes;

struct ShShape {
  int order, width, height;
  bool has_colours;
  StorageEncoding encoding;
  int first_level;
};

void PrintTo(const ShShape& s, std::ostream* out) {
  *out << "order " << s.order << ", " << s.width << " x " << s.height << (s.has_colours ? " colours " : " ")
       << storage_encoding_name(s.encoding) << " from level " << s.first_level;
}

// Makes harmonics as a bake does: level 0 has single directions, and other levels are weaker.
ShMipmap random_harmonics(const ShShape& shape, unsigned seed) {
  std::mt19937 random(seed);
  ShMipmap mipmap;
  BakedHeader& header = mipmap.header;
  header.representation = Representation::kSh;
  header.encoding = shape.encoding;
  header.wrap_s = WrapMode::kClamp;
  header.wrap_t = WrapMode::kMirror;
  header.provenance = {"multum test", "map.png", std::string(64, 'a'), "{\"sh_order\":4}", std::string(64, 'b'),
                       "[]",          ""};
  header.width = shape.width;
  header.height = shape.height;
  header.first_level = shape.first_level;
  header.has_colours = shape.has_colours;
  mipmap.order = shape.order;
  mipmap.levels = empty_sh_levels(shape.width, shape.height);
  for (int l = shape.first_level; l < header.level_count(); ++l) {
    ShLevel& level = mipmap.levels[static_cast<std::size_t>(l)];
    const auto texels = static_cast<std::size_t>(level.width) * static_cast<std::size_t>(level.height);
    level.parts.assign(static_cast<std::size_t>(sh_part_count(shape.order)),
                       std::vector<glm::vec4>(texels, glm::vec4(0.0f)));
    for (std::size_t i = 0; i < texels; ++i) {
      const std::vector<double> basis = reference::sh_basis_to(shape.order, random_direction(random, 1.4));
      const double share = l == 0 ? 1.0 : uniform(random);
      for (std::size_t k = 0; k < basis.size(); ++k)
        level.parts[k / 4][i][static_cast<int>(k % 4)] = static_cast<float>(share * basis[k]);
      if (shape.has_colours) level.colours.emplace_back(uniform(random), uniform(random), uniform(random));
    }
    quantize_sh(level, shape.encoding, 1);
  }
  return mipmap;
}

void expect_same(const ShMipmap& found, const ShMipmap& expected) {
  EXPECT_EQ(found.order, expected.order);
  ASSERT_EQ(found.levels.size(), expected.levels.size());
  for (std::size_t l = 0; l < expected.levels.size(); ++l) {
    EXPECT_EQ(found.levels[l].width, expected.levels[l].width);
    EXPECT_TRUE(found.levels[l].parts == expected.levels[l].parts) << l;
    EXPECT_TRUE(found.levels[l].colours == expected.levels[l].colours) << l;
  }
}

constexpr ShShape kDefault = {4, 40, 24, true, StorageEncoding::kHalf, 0};

class ShFileTest : public ::testing::TestWithParam<ShShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, ShFileTest,
                         ::testing::Values(ShShape{8, 1, 1, false, StorageEncoding::kHalf, 0}, kDefault,
                                           ShShape{3, 40, 24, false, StorageEncoding::kFloat, 2},
                                           ShShape{1, 1, 300, true, StorageEncoding::kFloat, 0},
                                           ShShape{20, 9, 5, true, StorageEncoding::kHalf, 1}));

TEST_P(ShFileTest, WhatIsWrittenIsRead) {
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  ShMipmap mipmap = random_harmonics(GetParam(), 3);
  mipmap.header.provenance.measured_error = "[[0,\"centre\",\"lambert\",0.5]]";
  BakedWriteOptions options;
  options.tile_size = 32;
  write_sh_mipmap(path, mipmap, options);
  expect_same(read_sh_mipmap(path, 2), mipmap);
  const BakedHeader header = read_baked_header(path);
  EXPECT_EQ(header.representation, Representation::kSh);
  EXPECT_EQ(header.encoding, GetParam().encoding);
  EXPECT_EQ(header.wrap_s, WrapMode::kClamp);
  EXPECT_EQ(header.first_level, GetParam().first_level);
  EXPECT_EQ(header.has_colours, GetParam().has_colours);
  EXPECT_EQ(header.provenance.measured_error, mipmap.header.provenance.measured_error);
  EXPECT_EQ(read_sh_header(path).order, GetParam().order);
  for (const VerifyFinding& finding : verify_baked(path, 2)) EXPECT_TRUE(finding.passed) << finding.detail;
}

// Writes portions of rows that do not match the rows of tiles, with alternating levels. The pixels must not change.
TEST_P(ShFileTest, PortionsMakeTheSameFile) {
  const TemporaryFolder folder;
  const ShMipmap mipmap = random_harmonics(GetParam(), 5);
  BakedWriteOptions options;
  options.tile_size = 32;
  options.measured_error_bytes = 2;
  write_sh_mipmap(folder / "whole.exr", mipmap, options);
  ShWriter writer(folder / "rows.exr", mipmap.header, mipmap.order, options);
  testing::write_in_portions(writer, mipmap,
                             [](const auto& level, int row, int count) { return rows_of(level, row, count); });
  writer.commit("[]");
  expect_same(read_sh_mipmap(folder / "rows.exr"), mipmap);
  EXPECT_EQ(writer.content_hash(), read_baked_header(folder / "whole.exr").provenance.content_hash);
}

TEST(ShWriterTest, WithoutCommitNothingStays) {
  const TemporaryFolder folder;
  { ShWriter writer(folder / "a.exr", random_harmonics(kDefault, 1).header, 4, {}); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// For wide maps with many coefficients, the writer uses tiles with fewer rows, but at least 16.
TEST(ShWriterTest, TilesAreLowerWhereTheyAreLong) {
  EXPECT_EQ(sh_tile_size(1024, 4, 128), 128);
  EXPECT_EQ(sh_tile_size(4096, 4, 128), 64);
  EXPECT_EQ(sh_tile_size(4096, 8, 128), 16);
  EXPECT_EQ(sh_tile_size(32768, 20, 128), 16);
}

TEST(ShGpuBytesTest, AnArrayAndATextureOfColours) {
  ShMipmap mipmap = random_harmonics({8, 16, 16, false, StorageEncoding::kHalf, 0}, 1);
  constexpr std::uint64_t kTexels = 256 + 64 + 16 + 4 + 1;
  EXPECT_EQ(sh_gpu_bytes(mipmap), kTexels * 20 * 8);
  mipmap.header.has_colours = true;
  mipmap.header.encoding = StorageEncoding::kFloat;
  EXPECT_EQ(sh_gpu_bytes(mipmap), kTexels * 21 * 16);
}

class ShRefusalTest : public ::testing::Test {
 protected:
  ShRefusalTest() {
    BakedWriteOptions options;
    options.compression = "none";
    write_sh_mipmap(file_.good, random_harmonics(kDefault, 2), options);
  }

  void expect_refusal(const std::string& path, std::vector<std::string> parts) const {
    parts.push_back(path);
    expect_error(ErrorCode::kInput, parts, [&] { read_sh_mipmap(path); });
    expect_error(ErrorCode::kInput, {path}, [&] { verify_baked(path, 1); });
  }

  std::string with_order(int order) const {
    return file_.rebuilt({0, 1, 2, 3, 4, 5, 6},
                         [order](Imf::Header& h) { h.insert("multum:shOrder", Imf::IntAttribute(order)); });
  }

  const testing::AlteredFile file_;
};

TEST_F(ShRefusalTest, FilesThatAreSomethingElse) {
  EXPECT_NO_THROW(read_sh_mipmap(file_.good));
  expect_refusal(file_.folder / "none.exr", {});
  expect_error(ErrorCode::kInput, {"found representation 'sh'", "expected 'moments'"},
               [&] { read_moment_mipmap(file_.good); });
  expect_refusal(with_order(5), {"found 7 parts", "expected 10"});
  for (const int order : {-1, 0, 21, 46341, std::numeric_limits<int>::max()})
    expect_refusal(with_order(order), {"order", std::to_string(order), "1 to 20"});
  expect_refusal(file_.rebuilt({0, 1, 2, 3, 4, 5, 6}, [](Imf::Header& h) { h.erase("multum:shOrder"); }),
                 {"multum:shOrder"});
  expect_refusal(file_.rebuilt({0, 1, 2, 3, 4, 5}, [](Imf::Header&) {}), {"found 6 parts", "expected 7"});
  expect_refusal(file_.rebuilt({0, 2, 1, 3, 4, 5, 6}, [](Imf::Header&) {}),
                 {"part 1 named 'sh.02'", "expected 'sh.01'"});
  const std::string bytes = read_bytes(file_.good);
  for (const std::size_t size : {std::size_t{100}, bytes.size() / 3, bytes.size() - 1}) {
    write_bytes(file_.bad, bytes.substr(0, size));
    expect_refusal(file_.bad, {"baked file"});
  }
}

// Returns the failed checks of a file whose texels were changed after rounding.
std::vector<std::string> failures(int level, const std::function<void(ShLevel&)>& change) {
  const TemporaryFolder folder;
  ShMipmap mipmap = random_harmonics(kDefault, 9);
  change(mipmap.levels[static_cast<std::size_t>(level)]);
  write_sh_mipmap(folder / "a.exr", mipmap, {.is_checked = false});
  std::vector<std::string> failed;
  for (const VerifyFinding& finding : verify_sh(folder / "a.exr", 2))
    if (!finding.passed) failed.push_back(finding.check);
  return failed;
}

TEST(ShVerifyTest, EachCheckFindsItsDamage) {
  using Failures = std::vector<std::string>;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();
  EXPECT_EQ(failures(1, [](ShLevel&) {}), Failures{});
  EXPECT_EQ(failures(1, [](ShLevel& l) { l.parts[5][7].w = kNan; }), Failures{"finite"});
  EXPECT_EQ(failures(1, [](ShLevel& l) { l.colours[7].y = kInf; }), Failures{"finite"});
  EXPECT_EQ(failures(1, [](ShLevel& l) { l.parts[2][7].x = 1.0f; }), Failures{"power"});
  EXPECT_EQ(failures(0, [](ShLevel& l) { l.parts[0][7] *= 0.5f; }), Failures{"level 0"});
}

TEST(ShVerifyTest, AFlippedBitIsFound) {
  const TemporaryFolder folder;
  BakedWriteOptions options;
  options.compression = "none";
  const std::string path = folder / "a.exr";
  write_sh_mipmap(path, random_harmonics({2, 40, 24, false, StorageEncoding::kFloat, 0}, 9), options);
  std::string bytes = read_bytes(path);
  bytes[bytes.size() - 5] = static_cast<char>(bytes[bytes.size() - 5] ^ 1);  // in the last level's pixels
  write_bytes(path, bytes);
  bool checksum_failed = false;
  for (const VerifyFinding& finding : verify_sh(path, 1))
    if (finding.check == "checksum") checksum_failed = !finding.passed;
  EXPECT_TRUE(checksum_failed);
}

TEST(ShQuantizeTest, HalfsLoseATwoThousandthAtMost) {
  const ShMipmap exact = random_harmonics({8, 32, 32, true, StorageEncoding::kFloat, 0}, 11);
  ShMipmap rounded = exact;
  for (std::size_t l = 0; l < exact.levels.size(); ++l) {
    quantize_sh(rounded.levels[l], StorageEncoding::kHalf, 2);
    for (std::size_t p = 0; p < exact.levels[l].parts.size(); ++p)
      for (std::size_t i = 0; i < exact.levels[l].parts[p].size(); ++i)
        for (int c = 0; c < 4; ++c) {
          const auto value = static_cast<double>(exact.levels[l].parts[p][i][c]);
          ASSERT_NEAR(static_cast<double>(rounded.levels[l].parts[p][i][c]), value, std::abs(value) * 0x1p-11 + 3e-8);
        }
  }
}

}  // namespace
}  // namespace multum
