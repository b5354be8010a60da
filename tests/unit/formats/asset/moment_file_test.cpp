// SPDX-License-Identifier: Apache-2.0
// Tests baked files of moments: rounding, writing, reading, refusal, and verification.
#include <ImfHeader.h>
#include <ImfIntAttribute.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfTiledInputPart.h>
#include <ImfTiledOutputPart.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <limits>

#include "host/formats/asset/averages/moment_file.h"
#include "host/formats/asset/averages/moment_verify.h"
#include "host/formats/asset/baked_verify.h"
#include "host/formats/asset/gpu_bytes.h"
#include "host/formats/asset/lobes/movmf_mipmap.h"
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

// Makes moments as a bake does: level 0 has single directions, and other levels have a variance.
MomentMipmap random_moments(int width, int height, bool has_colours, StorageEncoding encoding, unsigned seed) {
  std::mt19937 random(seed);
  MomentMipmap mipmap;
  mipmap.header.representation = Representation::kMoments;
  mipmap.header.encoding = encoding;
  mipmap.header.wrap_s = WrapMode::kClamp;
  mipmap.header.wrap_t = WrapMode::kMirror;
  mipmap.header.provenance = {
      "multum test", "map.png", std::string(64, 'a'), "{\"first_level\":0}", std::string(64, 'b'), "[]", ""};
  mipmap.header.width = width;
  mipmap.header.height = height;
  mipmap.header.has_colours = has_colours;
  mipmap.levels = empty_moment_levels(width, height);
  for (std::size_t l = 0; l < mipmap.levels.size(); ++l) {
    MomentLevel& level = mipmap.levels[l];
    for (int i = 0; i < level.width * level.height; ++i) {
      const glm::dvec3 n = random_direction(random, 1.4);
      const double s = -n.x / n.z, t = -n.y / n.z, deviation = l == 0 ? 0.0 : std::pow(10.0, -2.0 * uniform(random));
      SlopeMoments m;
      m.s = static_cast<float>(s);
      m.t = static_cast<float>(t);
      m.ss = l == 0 ? m.s * m.s : static_cast<float>(s * s + deviation * deviation);
      m.tt = l == 0 ? m.t * m.t : static_cast<float>(t * t + deviation * deviation);
      m.st = l == 0 ? m.s * m.t : static_cast<float>(s * t + 0.5 * deviation * deviation);
      level.slopes.push_back(m);
      level.normals.emplace_back(n * (l == 0 ? 1.0 : uniform(random)));
      if (has_colours) level.colours.emplace_back(uniform(random), uniform(random), uniform(random));
    }
  }
  for (MomentLevel& level : mipmap.levels) quantize_moments(level, encoding, 1);
  return mipmap;
}

void expect_same_bits(const MomentMipmap& found, const MomentMipmap& expected) {
  ASSERT_EQ(found.levels.size(), expected.levels.size());
  for (std::size_t l = static_cast<std::size_t>(expected.header.first_level); l < expected.levels.size(); ++l) {
    const MomentLevel &a = found.levels[l], &b = expected.levels[l];
    ASSERT_EQ(a.slopes.size(), b.slopes.size());
    ASSERT_EQ(a.normals.size(), b.normals.size());
    ASSERT_EQ(a.colours.size(), b.colours.size());
    EXPECT_EQ(std::memcmp(a.slopes.data(), b.slopes.data(), b.slopes.size() * sizeof(SlopeMoments)), 0) << l;
    EXPECT_EQ(std::memcmp(a.normals.data(), b.normals.data(), b.normals.size() * sizeof(glm::vec3)), 0) << l;
    EXPECT_EQ(a.colours, b.colours) << l;
  }
}

struct MomentShape {
  int width, height;
  bool has_colours;
  StorageEncoding encoding;
  int first_level;
};

void PrintTo(const MomentShape& s, std::ostream* out) {
  *out << s.width << " x " << s.height << (s.has_colours ? " colours " : " ") << storage_encoding_name(s.encoding)
       << " from level " << s.first_level;
}

class MomentFileTest : public ::testing::TestWithParam<MomentShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, MomentFileTest,
                         ::testing::Values(MomentShape{1, 1, false, StorageEncoding::kHalf, 0},
                                           MomentShape{40, 24, true, StorageEncoding::kHalf, 0},
                                           MomentShape{40, 24, false, StorageEncoding::kFloat, 2},
                                           MomentShape{1, 300, true, StorageEncoding::kFloat, 0},
                                           MomentShape{200, 130, true, StorageEncoding::kHalf, 1}));

TEST_P(MomentFileTest, WhatIsWrittenIsRead) {
  const auto [width, height, has_colours, encoding, first_level] = GetParam();
  const TemporaryFolder folder;
  const std::string path = folder / "a.exr";
  MomentMipmap mipmap = random_moments(width, height, has_colours, encoding, 3);
  mipmap.header.first_level = first_level;
  mipmap.header.provenance.measured_error = "[[0,\"centre\",\"lambert lean\",0.5]]";
  BakedWriteOptions options;
  options.tile_size = 32;
  write_moment_mipmap(path, mipmap, options);
  const MomentMipmap read = read_moment_mipmap(path, 2);
  expect_same_bits(read, mipmap);
  const BakedHeader header = read_baked_header(path);
  EXPECT_EQ(header.representation, Representation::kMoments);
  EXPECT_EQ(header.encoding, encoding);
  EXPECT_EQ(header.wrap_s, WrapMode::kClamp);
  EXPECT_EQ(header.wrap_t, WrapMode::kMirror);
  EXPECT_EQ(header.width, width);
  EXPECT_EQ(header.height, height);
  EXPECT_EQ(header.first_level, first_level);
  EXPECT_EQ(header.has_colours, has_colours);
  EXPECT_EQ(header.provenance.measured_error, mipmap.header.provenance.measured_error);
  EXPECT_EQ(header.provenance.settings, mipmap.header.provenance.settings);
  for (const VerifyFinding& finding : verify_baked(path, 2)) EXPECT_TRUE(finding.passed) << finding.detail;
}

// Writes portions of rows that do not match the rows of tiles, with alternating levels. The bytes must not change.
TEST_P(MomentFileTest, PortionsMakeTheSameFile) {
  const MomentShape shape = GetParam();
  const TemporaryFolder folder;
  MomentMipmap mipmap = random_moments(shape.width, shape.height, shape.has_colours, shape.encoding, 5);
  mipmap.header.first_level = shape.first_level;
  BakedWriteOptions options;
  options.tile_size = 32;
  options.measured_error_bytes = 2;
  write_moment_mipmap(folder / "whole.exr", mipmap, options);
  MomentWriter writer(folder / "rows.exr", mipmap.header, options);
  testing::write_in_portions(writer, mipmap,
                             [](const auto& level, int row, int count) { return rows_of(level, row, count); });
  writer.commit("[]");
  expect_same_bits(read_moment_mipmap(folder / "rows.exr"), mipmap);
  EXPECT_EQ(writer.content_hash(), read_baked_header(folder / "whole.exr").provenance.content_hash);
}

TEST(MomentWriterTest, WithoutCommitNothingStays) {
  const TemporaryFolder folder;
  { MomentWriter writer(folder / "a.exr", random_moments(8, 8, false, StorageEncoding::kHalf, 1).header, {}); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

// Tests the statements of the format page about 16-bit floats.
TEST(MomentQuantizeTest, SingleDirectionsGetNoVariance) {
  const MomentMipmap mipmap = random_moments(128, 128, false, StorageEncoding::kHalf, 7);
  for (std::size_t i = 0; i < mipmap.levels[0].slopes.size(); ++i) {
    const SlopeMoments& m = mipmap.levels[0].slopes[i];
    const auto s = static_cast<double>(m.s), t = static_cast<double>(m.t);
    EXPECT_LE(static_cast<double>(m.ss), s * s);
    EXPECT_LE(static_cast<double>(m.tt), t * t);
    EXPECT_GE(static_cast<double>(m.ss), s * s * (1.0 - 0x1p-10) - 6e-8);
    EXPECT_GE(glm::length(glm::dvec3(mipmap.levels[0].normals[i])), 1.0 - 1e-9);
  }
}

TEST(MomentQuantizeTest, VariancesAreThoseAboutTheRoundedMeans) {
  std::mt19937 random(11);
  MomentLevel rows{1000, 1, {}, {}, {}};
  std::vector<double> variances;
  for (int i = 0; i < rows.width; ++i) {
    const double s = 6.0 * uniform(random) - 3.0, variance = std::pow(10.0, -3.0 * uniform(random));
    SlopeMoments m;
    m.s = static_cast<float>(s);
    m.ss = static_cast<float>(s * s + variance);
    rows.slopes.push_back(m);
    rows.normals.emplace_back(0.0f, 0.0f, 1.0f);
    variances.push_back(variance);
  }
  quantize_moments(rows, StorageEncoding::kHalf, 1);
  for (std::size_t i = 0; i < variances.size(); ++i) {
    const auto s = static_cast<double>(rows.slopes[i].s), ss = static_cast<double>(rows.slopes[i].ss);
    // The bound is half a step of the moment plus the rounding error of the variance as a float.
    EXPECT_NEAR(ss - s * s, variances[i], ss * (0x1p-11 + 0x1p-20)) << s;
  }
}

// least_slope_deviation() promises that, at a slope of 1, rounding changes this variance and larger variances by at
// most a quarter. Much smaller variances change more, so the limit is tight.
TEST(MomentQuantizeTest, KeepsRoughnessDownToTheLeast) {
  std::mt19937 random(13);
  const auto worst = [&](StorageEncoding encoding, double deviation) {
    MomentLevel rows{4000, 1, {}, {}, {}};
    std::vector<double> exact;
    for (int i = 0; i < rows.width; ++i) {
      const double b = std::pow(2.0, 8.0 * uniform(random) - 6.0);  // slopes from 1/64 to 4
      SlopeMoments m;
      m.s = static_cast<float>(b);
      const double variance = deviation * deviation * b * b;
      m.ss = static_cast<float>(static_cast<double>(m.s) * static_cast<double>(m.s) + variance);
      rows.slopes.push_back(m);
      rows.normals.emplace_back(0.0f, 0.0f, 1.0f);
      exact.push_back(variance);
    }
    quantize_moments(rows, encoding, 1);
    double off = 0.0;
    for (std::size_t i = 0; i < exact.size(); ++i) {
      const auto s = static_cast<double>(rows.slopes[i].s);
      off = std::max(off, std::abs(static_cast<double>(rows.slopes[i].ss) - s * s - exact[i]) / exact[i]);
    }
    return off;
  };
  for (const StorageEncoding encoding : {StorageEncoding::kHalf, StorageEncoding::kFloat}) {
    const auto least = static_cast<double>(least_slope_deviation(encoding));
    EXPECT_LE(worst(encoding, least), 0.26) << storage_encoding_name(encoding);
    EXPECT_LE(worst(encoding, 4.0 * least), 0.02) << storage_encoding_name(encoding);
  }
  EXPECT_GT(worst(StorageEncoding::kHalf, 0.25 * static_cast<double>(least_slope_deviation(StorageEncoding::kHalf))),
            1.0);
}

TEST(RepresentationTest, EncodingsThatDoNotSuitAreRefused) {
  EXPECT_NO_THROW(check_encoding(Representation::kMovmf, StorageEncoding::kSnorm16));
  EXPECT_NO_THROW(check_encoding(Representation::kMoments, StorageEncoding::kFloat));
  expect_error(ErrorCode::kUsage, {"--data-format", "snorm16", "half", "float", "--ndf moments"},
               [] { check_encoding(Representation::kMoments, StorageEncoding::kSnorm16); });
}

TEST(MomentGpuBytesTest, TwoTexturesAndOneForColours) {
  BakedHeader header = random_moments(4, 2, false, StorageEncoding::kHalf, 1).header;
  EXPECT_EQ(moment_gpu_bytes(header), (8u + 2u + 1u) * 2u * 8u);
  header.has_colours = true;
  header.encoding = StorageEncoding::kFloat;
  header.first_level = 1;
  EXPECT_EQ(moment_gpu_bytes(header), (2u + 1u) * 3u * 16u);
}

// Makes invalid files of moments from a good one.
class MomentRefusalTest : public ::testing::Test {
 protected:
  MomentRefusalTest() {
    BakedWriteOptions options;
    options.compression = "none";
    write_moment_mipmap(file_.good, random_moments(40, 24, true, StorageEncoding::kHalf, 2), options);
  }

  void expect_refusal(const std::string& path, std::vector<std::string> parts) const {
    parts.push_back(path);
    expect_error(ErrorCode::kInput, parts, [&] { read_moment_mipmap(path); });
    expect_error(ErrorCode::kInput, {path}, [&] { verify_baked(path, 1); });
  }

  const testing::AlteredFile file_;
};

TEST_F(MomentRefusalTest, FilesThatAreSomethingElse) {
  EXPECT_NO_THROW(read_moment_mipmap(file_.good));
  expect_refusal(file_.folder / "none.exr", {});
  expect_refusal(file_.replaced("moments", "momentz"), {"found representation 'momentz'", "expected 'moments'"});
  write_movmf_mipmap(file_.bad, testing::random_mipmap(8, 8, 1, false, StorageEncoding::kSnorm16, 1), {});
  expect_error(ErrorCode::kInput, {"found representation 'movmf'", "expected 'moments'"},
               [&] { read_moment_mipmap(file_.bad); });
  expect_error(ErrorCode::kInput, {"found representation 'moments'", "expected 'movmf'"},
               [&] { read_movmf_mipmap(file_.good); });
  expect_refusal(
      file_.rebuilt({0, 1, 2}, [](Imf::Header& h) { h.insert("multum:formatVersion", Imf::IntAttribute(3)); }),
      {"version 3", "version 1"});
  expect_refusal(file_.rebuilt({0, 1}, [](Imf::Header&) {}), {"found 2 parts", "expected 3"});
  expect_refusal(file_.rebuilt({0, 2, 1}, [](Imf::Header&) {}), {"part 1 named 'colour'", "expected 'normal'"});
  const std::string bytes = read_bytes(file_.good);
  for (const std::size_t size : {std::size_t{100}, bytes.size() / 3, bytes.size() - 1}) {
    write_bytes(file_.bad, bytes.substr(0, size));
    expect_refusal(file_.bad, {"baked file"});
  }
}

class MomentVerifyTest : public ::testing::Test {
 protected:
  // Returns the failed checks of a file whose texel was changed after rounding.
  std::vector<std::string> failures(const std::function<void(MomentLevel&)>& change) const {
    MomentMipmap mipmap = random_moments(40, 24, true, StorageEncoding::kHalf, 9);
    change(mipmap.levels[1]);
    write_moment_mipmap(folder_ / "a.exr", mipmap, {.is_checked = false});
    std::vector<std::string> failed;
    for (const VerifyFinding& finding : verify_moments(folder_ / "a.exr", 2))
      if (!finding.passed) failed.push_back(finding.check);
    return failed;
  }
  const TemporaryFolder folder_;
};

TEST_F(MomentVerifyTest, EachCheckFindsItsDamage) {
  using Failures = std::vector<std::string>;
  EXPECT_EQ(failures([](MomentLevel&) {}), Failures{});
  EXPECT_EQ(failures([](MomentLevel& l) { l.slopes[7].tt = std::numeric_limits<float>::quiet_NaN(); }),
            Failures{"finite"});
  EXPECT_EQ(failures([](MomentLevel& l) { l.colours[7].y = std::numeric_limits<float>::infinity(); }),
            Failures{"finite"});
  EXPECT_EQ(failures([](MomentLevel& l) { l.slopes[7] = {-1.0f, 1.0f, 0.0f, 0.875f, 1.0f, 0.0f}; }),
            Failures{"variance"});
  EXPECT_EQ(failures([](MomentLevel& l) { l.slopes[7] = {-1.0f, 0.0f, 0.0f, 1.0f, 1.0f, 1.5f}; }),
            Failures{"variance"});
  EXPECT_EQ(failures([](MomentLevel& l) { l.slopes[7] = {-1.0f, 24.0f, 0.0f, 576.0f, 0.0f, 0.0f}; }),
            Failures{"slope"});
  EXPECT_EQ(failures([](MomentLevel& l) { l.normals[7] = {0.0f, 0.75f, 0.75f}; }), Failures{"|n| <= 1"});
}

TEST_F(MomentVerifyTest, AFlippedBitIsFound) {
  BakedWriteOptions options;
  options.compression = "none";
  const std::string path = folder_ / "a.exr";
  write_moment_mipmap(path, random_moments(40, 24, false, StorageEncoding::kFloat, 9), options);
  std::string bytes = read_bytes(path);
  bytes[bytes.size() - 5] = static_cast<char>(bytes[bytes.size() - 5] ^ 1);  // in the last level's pixels
  write_bytes(path, bytes);
  bool checksum_failed = false;
  for (const VerifyFinding& finding : verify_moments(path, 1))
    if (finding.check == "checksum") checksum_failed = !finding.passed;
  EXPECT_TRUE(checksum_failed);
}

}  // namespace
}  // namespace multum
