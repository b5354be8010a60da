// SPDX-License-Identifier: Apache-2.0
// Tests that each kind of damage makes only the check fail that is meant for it.
#include "host/formats/asset/lobes/movmf_verify.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::Names;
using testing::TemporaryFolder;

class MovmfVerifyTest : public ::testing::TestWithParam<StorageEncoding> {
 protected:
  MovmfMipmap make() const {
    MovmfMipmap mipmap = testing::random_mipmap(40, 24, 4, true, GetParam(), 4);
    quantize_movmf(mipmap, 1);
    return mipmap;
  }

  std::string write(const MovmfMipmap& mipmap) const {
    BakedWriteOptions options;
    options.compression = "none";
    options.is_checked = false;
    write_movmf_mipmap(folder_ / "a.exr", mipmap, options);
    return folder_ / "a.exr";
  }

  static std::set<std::string> failed(const std::string& path) {
    std::set<std::string> names;
    for (const VerifyFinding& finding : verify_movmf(path, 2))
      if (!finding.passed) names.insert(finding.check);
    return names;
  }

  const TemporaryFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Encodings, MovmfVerifyTest,
                         ::testing::Values(StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat));

TEST_P(MovmfVerifyTest, AGoodFilePassesEveryCheck) {
  const std::vector<VerifyFinding> findings = verify_movmf(write(make()), 2);
  EXPECT_EQ(findings.size(), 7u);
  for (const VerifyFinding& finding : findings) EXPECT_TRUE(finding.passed) << finding.check << ": " << finding.detail;
}

TEST_P(MovmfVerifyTest, LevelsThatAreNotStoredAreNotMissed) {
  MovmfMipmap mipmap = make();
  drop_finer_levels(mipmap, 2);
  const std::vector<VerifyFinding> findings = verify_movmf(write(mipmap), 2);
  EXPECT_EQ(findings.size(), 7u);
  for (const VerifyFinding& finding : findings) EXPECT_TRUE(finding.passed) << finding.check << ": " << finding.detail;
  EXPECT_NE(findings[0].detail.find("40 x 24, levels 2 to 5 of 0 to 5, 4 lobes"), std::string::npos);
  // The message uses the level number of the map, which has 10 x 6 texels there.
  for (auto& lobe : mipmap.levels[2].lobes) lobe[10 * 4 + 7] *= 0.5f;
  for (const VerifyFinding& finding : verify_movmf(write(mipmap), 1))
    if (finding.check == "sum of a") {
      EXPECT_FALSE(finding.passed);
      EXPECT_NE(finding.detail.find("level 2, texel (7, 4)"), std::string::npos) << finding.detail;
    }
}

TEST_P(MovmfVerifyTest, EveryRowOfEveryTileIsSeenOnce) {
  MovmfMipmap mipmap = make();
  BakedWriteOptions options;
  options.tile_size = 5;  // 24 rows are four rows of tiles and a partial row of tiles
  for (const int first_level : {0, 2}) {
    drop_finer_levels(mipmap, first_level);
    write_movmf_mipmap(folder_ / "a.exr", mipmap, options);
    MovmfMipmap seen = read_movmf_header(folder_ / "a.exr");
    const auto gather = [&](int l, int first_row, const MovmfLevel& rows) {
      MovmfLevel& level = seen.levels[static_cast<std::size_t>(l)];
      EXPECT_EQ(level.lobes[0].size(), static_cast<std::size_t>(first_row * level.width)) << "level " << l;
      for (std::size_t j = 0; j < 4; ++j) {
        level.lobes[j].insert(level.lobes[j].end(), rows.lobes[j].begin(), rows.lobes[j].end());
        level.colours[j].insert(level.colours[j].end(), rows.colours[j].begin(), rows.colours[j].end());
      }
    };
    for (const VerifyFinding& finding : verify_movmf(folder_ / "a.exr", 2, gather))
      EXPECT_TRUE(finding.passed) << finding.check << ": " << finding.detail;
    for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
      EXPECT_EQ(seen.levels[l].lobes, mipmap.levels[l].lobes) << "level " << l;
      EXPECT_EQ(seen.levels[l].colours, mipmap.levels[l].colours) << "level " << l;
    }
  }
}

TEST_P(MovmfVerifyTest, AFlippedBitInAnyTileFailsTheChecksum) {
  const std::string path = write(make()), whole = testing::read_bytes(path);
  const unsigned seed = 6;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  // The last half of the file contains only chunks, so a byte there belongs to a pixel or to a chunk's header.
  for (int round = 0; round < 30; ++round) {
    std::string bytes = whole;
    const std::size_t at = whole.size() / 2 + random() % (whole.size() / 2);
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (random() % 8)));
    testing::write_bytes(path, bytes);
    SCOPED_TRACE(at);
    try {
      EXPECT_TRUE(failed(path).contains("checksum"));
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
    }
  }
}

TEST_P(MovmfVerifyTest, AWrongChecksumNamesBoth) {
  const std::string path = write(make());
  std::string bytes = testing::read_bytes(path);
  const std::string hash = read_movmf_header(path).header.provenance.content_hash;
  bytes.replace(bytes.find(hash), 4, "0000");
  testing::write_bytes(path, bytes);
  EXPECT_EQ(failed(path), (Names{"checksum", "header"}));  // the checksum is an attribute too
  for (const VerifyFinding& finding : verify_movmf(path, 1))
    if (finding.check == "checksum") {
      EXPECT_NE(finding.detail.find("found " + hash + ", expected 0000"), std::string::npos) << finding.detail;
    }
}

TEST_P(MovmfVerifyTest, AWrongSumNamesTheTexel) {
  MovmfMipmap mipmap = make();
  MovmfLevel& level = mipmap.levels[1];  // 20 x 12
  for (auto& lobe : level.lobes) lobe[20 * 7 + 3] *= 0.5f;
  const std::string path = write(mipmap);
  EXPECT_EQ(failed(path), Names{"sum of a"});
  for (const VerifyFinding& finding : verify_movmf(path, 1))
    if (finding.check == "sum of a") {
      EXPECT_NE(finding.detail.find("level 1, texel (3, 7)"), std::string::npos) << finding.detail;
    }
}

TEST_P(MovmfVerifyTest, NonFiniteValuesOfLobesAndColours) {
  for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    MovmfMipmap mipmap = make();
    mipmap.levels[2].lobes[1][5].x = value;
    EXPECT_TRUE(failed(write(mipmap)).contains("finite"));
    mipmap = make();
    mipmap.levels[1].colours[3][7].z = value;
    EXPECT_EQ(failed(write(mipmap)), Names{"finite"});
    mipmap = make();
    for (std::size_t j = 0; j < 4; ++j)
      if (mipmap.levels[0].lobes[j][7].w == 1.0f) mipmap.levels[0].colours[j][7].y = value;
    EXPECT_EQ(failed(write(mipmap)), Names{"finite"});
  }
}

TEST_P(MovmfVerifyTest, NegativeAmplitudes) {
  MovmfMipmap mipmap = make();
  MovmfLevel& level = mipmap.levels[1];
  level.lobes[0][3] = glm::vec4(0.0f, 0.0f, 0.0f, -0.25f);
  level.lobes[1][3] = level.lobes[2][3] = glm::vec4(0.0f);
  level.lobes[3][3] = glm::vec4(0.0f, 0.0f, 0.5f, 1.25f);
  const Names names = failed(write(mipmap));
  EXPECT_TRUE(names.contains("a >= 0"));
}

TEST_P(MovmfVerifyTest, MeansLongerThanRoundingAllows) {
  MovmfMipmap mipmap = make();
  for (std::size_t j = 0; j < 4; ++j) mipmap.levels[1].lobes[j][9] = glm::vec4(0.0f, 0.0f, 0.25f, 0.25f);
  EXPECT_EQ(failed(write(mipmap)), Names{});
  mipmap.levels[1].lobes[2][9].x = 0.03125f;  // |a r| = 0.2519
  EXPECT_EQ(failed(write(mipmap)), Names{"|r| <= 1"});
}

TEST(MovmfVerifyStructureTest, WhatIsNoBakedFileIsThrown) {
  const TemporaryFolder folder;
  testing::expect_error(ErrorCode::kInput, {folder / "none"}, [&] { verify_movmf(folder / "none", 1); });
}

}  // namespace
}  // namespace multum
