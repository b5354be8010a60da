// SPDX-License-Identifier: Apache-2.0
// Tests baked files of planar Gaussians: rounding, writing, reading, refusal, and verification.
#include <half.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>

#include "host/formats/asset/averages/moment_mipmap.h"
#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/asset/lobes/gmm_quantize.h"
#include "host/foundation/base/error.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::Names;
using testing::random_direction;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::uniform;
using testing::write_bytes;

glm::vec4 gaussian(double a, const glm::dvec3& n, double variance) {
  // For unit vectors E|p|^2 is at most 1.
  const double scale = std::sqrt(std::max(0.0, 1.0 - 2.0 * variance)), x = scale * n.x, y = scale * n.y;
  return glm::vec4(glm::dvec4(x, y, 2.0 * variance + x * x + y * y, 1.0) * a);
}

// Makes rounded random Gaussians of every width, including single directions.
MovmfMipmap random_gaussians(int width, int height, int lobe_count, bool colours, StorageEncoding encoding,
                             unsigned seed) {
  MovmfMipmap mipmap = testing::random_mipmap(width, height, lobe_count, colours, encoding, seed);
  mipmap.header.representation = Representation::kGmm;
  std::mt19937 random(seed);
  for (MovmfLevel& level : mipmap.levels)
    for (auto& lobes : level.lobes)
      for (glm::vec4& lobe : lobes) {
        if (lobe.w == 0.0f) continue;
        const glm::dvec3 n = &level == &mipmap.levels[0] ? glm::dvec3(lobe) : random_direction(random, 1.5);
        const bool single = &level == &mipmap.levels[0] || uniform(random) < 0.2;
        lobe = gaussian(static_cast<double>(lobe.w), n, single ? 0.0 : 0.3 * std::pow(10.0, -4.0 * uniform(random)));
      }
  quantize_movmf(mipmap, 2);
  return mipmap;
}

class GmmFileTest : public ::testing::TestWithParam<StorageEncoding> {
 protected:
  std::string write(const MovmfMipmap& mipmap) const {
    BakedWriteOptions options;
    options.tile_size = 32;
    options.compression = "none";
    options.is_checked = false;
    write_movmf_mipmap(path(), mipmap, options);
    return path();
  }
  std::string path() const { return folder_ / "a.exr"; }
  std::set<std::string> failed() const {
    std::set<std::string> names;
    for (const VerifyFinding& finding : verify_baked(path(), 2))
      if (!finding.passed) names.insert(finding.check);
    return names;
  }
  MovmfMipmap make() const { return random_gaussians(70, 41, 3, true, GetParam(), 5); }
  TemporaryFolder folder_;
};

INSTANTIATE_TEST_SUITE_P(Encodings, GmmFileTest,
                         ::testing::Values(StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat),
                         [](const auto& encoding) { return storage_encoding_name(encoding.param); });

TEST_P(GmmFileTest, WhatIsWrittenIsRead) {
  for (const int first_level : {0, 2}) {
    MovmfMipmap mipmap = make();
    drop_finer_levels(mipmap, first_level);
    write(mipmap);
    const MovmfMipmap read = read_movmf_mipmap(path(), 2);
    EXPECT_EQ(read.header.representation, Representation::kGmm);
    if (first_level == 0) testing::expect_same_bits(read, mipmap);
    EXPECT_EQ(read.header.provenance.content_hash, movmf_content_hash(mipmap, 1));
    const BakedHeader header = read_baked_header(path());
    EXPECT_EQ(header.representation, Representation::kGmm);
    EXPECT_EQ(header.first_level, first_level);
    EXPECT_EQ(failed(), std::set<std::string>{});
    EXPECT_EQ(movmf_gpu_bytes(read), movmf_gpu_bytes(mipmap));
  }
}

TEST_P(GmmFileTest, BadValuesFailTheCheckThatIsForThem) {
  const auto with = [&](const glm::vec4& lobe) {
    MovmfMipmap mipmap = make();
    for (auto& lobes : mipmap.levels[1].lobes) lobes[9] = glm::vec4(0.0f);
    mipmap.levels[1].lobes[1][9] = lobe;
    write(mipmap);
    return failed();
  };
  EXPECT_EQ(with({0.5f, 0.0f, 0.25f, 1.0f}), Names{});
  EXPECT_EQ(with({0.5f, 0.0f, 0.234375f, 1.0f}), Names{"variance"});
  EXPECT_EQ(with({1.0f, 0.25f, 1.125f, 1.0f}), Names{"|mean| <= 1"});
  EXPECT_EQ(with({0.25f, 0.0f, 0.25f, 0.5f}), Names{"sum of a"});
  EXPECT_TRUE(with({0.0f, 0.0f, std::numeric_limits<float>::quiet_NaN(), 1.0f}).contains("finite"));
  EXPECT_TRUE(with({0.0f, 0.0f, 0.0f, -1.0f}).contains("a >= 0"));
}

TEST_P(GmmFileTest, DamagedAndTruncatedFilesAreFoundOut) {
  write(make());
  const std::string whole = read_bytes(path());
  for (const double share : {0.1, 0.5, 0.9}) {
    write_bytes(path(), whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
    expect_error(ErrorCode::kInput, {path()}, [&] { read_movmf_mipmap(path()); });
  }
  std::string bytes = whole;
  for (std::size_t i = 0; i < 64; ++i) bytes[bytes.size() - 5000 + i] ^= 1;
  write_bytes(path(), bytes);
  try {
    EXPECT_TRUE(failed().contains("checksum"));
  } catch (const Error& error) {  // the header of a tile was overwritten
    EXPECT_EQ(error.code(), ErrorCode::kInput);
  }
}

// A file of one kind is refused where another kind is expected. A file of an unknown version is also refused.
TEST_P(GmmFileTest, OtherFilesAreRefused) {
  write(make());
  expect_error(ErrorCode::kInput, {path(), "'gmm'", "'moments'"}, [&] { read_moment_mipmap(path()); });
  std::string bytes = read_bytes(path());
  const std::size_t at = bytes.find("formatVersion");
  ASSERT_NE(at, std::string::npos);
  for (std::size_t i = 0; i < bytes.size() - 30; ++i)  // in every part
    if (bytes.compare(i, 13, "formatVersion") == 0) bytes[i + 22] = 9;
  write_bytes(path(), bytes);
  expect_error(ErrorCode::kInput, {path(), "format version 9"}, [&] { read_movmf_mipmap(path()); });
}

class GmmQuantizeTest : public ::testing::TestWithParam<StorageEncoding> {
 protected:
  static MovmfLevel rounded(MovmfLevel level) {
    quantize_gmm(level, GetParam(), 2);
    return level;
  }
};

INSTANTIATE_TEST_SUITE_P(Encodings, GmmQuantizeTest,
                         ::testing::Values(StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat),
                         [](const auto& encoding) { return storage_encoding_name(encoding.param); });

// At every tilt, gmm_kappa_max() promises that rounding changes this variance and larger variances by at most a
// quarter. Much smaller variances change more, so the limit is tight.
TEST_P(GmmQuantizeTest, KeepsVariance) {
  const auto worst = [](double variance) {
    std::mt19937 random(21);
    MovmfLevel level{3000, 1, {{}}, {}};
    for (int i = 0; i < level.width; ++i)
      level.lobes[0].push_back(gaussian(1.0, random_direction(random, M_PI / 2.0), variance));
    level = rounded(level);
    double off = 0.0;
    for (const glm::vec4& lobe : level.lobes[0])
      off = std::max(off, std::abs(static_cast<double>(gmm_variance(lobe)) - variance) / variance);
    return off;
  };
  const double least = 1.0 / static_cast<double>(gmm_kappa_max(GetParam()));
  EXPECT_LE(worst(least), 0.252);
  EXPECT_LE(worst(10.0 * least), 0.026);
  if (GetParam() != StorageEncoding::kFloat) {
    EXPECT_GT(worst(0.1 * least), 0.9);
  }
}

// Single directions get a variance of 0, even if they are filtered together with texels of the same direction.
TEST_P(GmmQuantizeTest, SingleDirectionsGetNone) {
  std::mt19937 random(22);
  MovmfLevel level{2000, 1, {{}, {}}, {}};
  for (int i = 0; i < level.width; i += 2) {
    const glm::dvec3 n = random_direction(random, M_PI / 2.0);
    for (int k = 0; k < 2; ++k) {
      const double a = uniform(random);
      level.lobes[0].push_back(gaussian(a, n, 0.0));
      level.lobes[1].push_back(gaussian(1.0 - a, random_direction(random, 1.0), 0.0));
    }
  }
  level = rounded(level);
  // Two rounded means differ by up to one step, which adds a spread of the square of this step. Floats differ by at
  // most 8 roundings.
  const double zero = GetParam() == StorageEncoding::kFloat ? 5e-7 : 1e-15;  // rounding error of doubles
  for (std::size_t i = 0; i < 2000; ++i)
    for (const auto& lobes : level.lobes) EXPECT_LE(static_cast<double>(gmm_variance(lobes[i])), zero) << i;
  for (std::size_t i = 0; i < 2000; i += 2) {
    const glm::vec4 filtered = 0.5f * (level.lobes[0][i] + level.lobes[0][i + 1]);
    if (filtered.w > 0.01f) {
      EXPECT_LT(static_cast<double>(gmm_variance(filtered)), 1e-6) << i;
    }
  }
}

TEST_P(GmmQuantizeTest, AmplitudesSumToOneAndRoundingTwiceChangesNothing) {
  const MovmfMipmap mipmap = random_gaussians(60, 60, 4, true, GetParam(), 9);
  const MovmfLevel& once = mipmap.levels[1];
  for (std::size_t i = 0; i < once.lobes[0].size(); ++i) {
    double sum = 0.0;
    for (const auto& lobes : once.lobes) sum += static_cast<double>(lobes[i].w);
    EXPECT_NEAR(sum, 1.0, GetParam() == StorageEncoding::kHalf ? 1e-3 : 1e-6);
  }
  const MovmfLevel twice = rounded(once);
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < once.lobes[j].size(); ++i) {
      EXPECT_EQ(twice.lobes[j][i].w, once.lobes[j][i].w);
      EXPECT_EQ(twice.lobes[j][i].x, once.lobes[j][i].x);
    }
}

// Tests level 0 with integers, as docs/reference/file_format.md defines it.
TEST(GmmFinestTest, TheThirdIsTheSquareRoundedDown) {
  std::mt19937 random(23);
  for (int n = 0; n < 2000; ++n) {
    const int i = static_cast<int>(random() % 65535) - 32767, j = static_cast<int>(random() % 65535) - 32767;
    const float x = static_cast<float>(i / 32767.0), y = static_cast<float>(j / 32767.0);
    const int expected =
        static_cast<int>(std::min<std::int64_t>((std::int64_t{i} * i + std::int64_t{j} * j) / 32767, 32767));
    if (std::int64_t{i} * i + std::int64_t{j} * j > std::int64_t{32767} * 32767) continue;  // not a normal
    EXPECT_EQ(finest_square(x, y, StorageEncoding::kSnorm16), static_cast<float>(expected / 32767.0)) << i << " " << j;
    const auto hx = static_cast<float>(half(x)), hy = static_cast<float>(half(y));
    const double exact =
        static_cast<double>(hx) * static_cast<double>(hx) + static_cast<double>(hy) * static_cast<double>(hy);
    const auto found = static_cast<double>(finest_square(hx, hy, StorageEncoding::kHalf));
    EXPECT_LE(found, exact);
    EXPECT_GE(found, exact * (1.0 - 0x1p-10) - 6e-8);
  }
}

// For horizontal normals, rounding to the nearest code may raise x^2 + y^2 above the largest value that the third
// channel can store.
TEST(GmmFinestTest, NormalsAtTheRimStayWithinIt) {
  MovmfFinest rows{20000, 1, {}, {}, {}};
  rows.representation = Representation::kGmm;
  for (int i = 0; i < rows.width; ++i) {
    const double turn = 2.0 * M_PI * i / rows.width;
    rows.normals.emplace_back(std::cos(turn), std::sin(turn), 1.0);
  }
  rows.lobe.resize(rows.normals.size());
  const MovmfFinest before = rows;
  quantize_movmf(rows, StorageEncoding::kSnorm16, 1);
  for (std::size_t i = 0; i < rows.normals.size(); ++i) {
    const double x = std::round(static_cast<double>(rows.normals[i].x) * 32767.0),
                 y = std::round(static_cast<double>(rows.normals[i].y) * 32767.0);
    EXPECT_LE(x * x + y * y, 32767.0 * 32767.0);
    for (int c = 0; c < 2; ++c) EXPECT_NEAR(rows.normals[i][c], before.normals[i][c], 1.01f / 32767.0f);
  }
  const MovmfFinest once = rows;
  quantize_movmf(rows, StorageEncoding::kSnorm16, 1);
  EXPECT_EQ(rows.normals, once.normals);
}

}  // namespace
}  // namespace multum
