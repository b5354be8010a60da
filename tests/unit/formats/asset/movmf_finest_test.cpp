// SPDX-License-Identifier: Apache-2.0
// Tests level 0 if only x and y are stored. No spread is added, directions change only a little, and rows equal full
// lobes. Normals that are not single directions are rejected.
#include "host/formats/asset/lobes/movmf_finest.h"

#include <gtest/gtest.h>
#include <half.h>

#include "tests/unit/formats/asset/movmf_test_mipmap.h"

namespace multum {
namespace {

using testing::kDegree;
using testing::random_direction;
using testing::random_finest;

class FinestTest : public ::testing::TestWithParam<StorageEncoding> {
 protected:
  const unsigned seed_ = 21;
  std::mt19937 random_{seed_};
  const ::testing::ScopedTrace trace_{__FILE__, __LINE__, "seed " + std::to_string(seed_)};
};
INSTANTIATE_TEST_SUITE_P(Encodings, FinestTest,
                         ::testing::Values(StorageEncoding::kSnorm16, StorageEncoding::kHalf, StorageEncoding::kFloat));

// Returns the next lower value that the encoding can store.
float step_below(float z, StorageEncoding encoding) {
  if (encoding == StorageEncoding::kSnorm16)
    return static_cast<float>((std::round(static_cast<double>(z) * 32767.0) - 1.0) / 32767.0);
  if (encoding == StorageEncoding::kFloat) return std::nextafter(z, 0.0f);
  half below(z);
  below.setBits(static_cast<unsigned short>(below.bits() - 1));
  return static_cast<float>(below);
}

// Returns |(x, y, z)|^2 - 1 for stored values. The result is in steps for snorm16 and exact for 16-bit floats.
double excess(const glm::vec3& n, StorageEncoding encoding) {
  glm::dvec3 wide(n);
  if (encoding == StorageEncoding::kSnorm16)
    for (int c = 0; c < 3; ++c) wide[c] = std::round(wide[c] * 32767.0);
  const double one = encoding == StorageEncoding::kSnorm16 ? 32767.0 * 32767.0 : 1.0;
  return (wide.x * wide.x + wide.y * wide.y + wide.z * wide.z - one) / one;
}

TEST_P(FinestTest, ZIsTheLeastThatMakesTheLengthOne) {
  MovmfFinest rows = random_finest(random_, 500, 400, 4, false);
  for (std::size_t i = 0; i < rows.normals.size(); i += 3) rows.normals[i] *= glm::vec3(0.01f, 0.02f, 1.0f);  // flat
  quantize_movmf(rows, GetParam(), 2);
  const double rounding = GetParam() == StorageEncoding::kFloat ? 1e-15 : 0.0;  // rounding of the sum in excess()
  for (const glm::vec3& n : rows.normals) {
    ASSERT_GE(excess(n, GetParam()), -rounding) << n.x << " " << n.y << " " << n.z;
    if (n.z > 0.0f) {
      ASSERT_LE(excess({n.x, n.y, step_below(n.z, GetParam())}, GetParam()), rounding)
          << n.x << " " << n.y << " " << n.z;
    }
    ASSERT_EQ(n.z, finest_z(n.x, n.y, GetParam()));
  }
}

TEST_P(FinestTest, TurnsDirectionsByLittle) {
  for (const double tilt_max : {10.0, 45.0, 70.0, 84.0, 90.0}) {
    double worst = 0.0;
    MovmfFinest rows{200000, 1, {}, {}, {}};
    for (int i = 0; i < rows.width; ++i) rows.normals.emplace_back(random_direction(random_, tilt_max * kDegree));
    rows.lobe.resize(rows.normals.size());
    const MovmfFinest before = rows;
    quantize_movmf(rows, GetParam(), 1);
    for (std::size_t i = 0; i < rows.normals.size(); ++i) {
      const glm::dvec3 a(before.normals[i]), b = glm::normalize(glm::dvec3(rows.normals[i]));
      worst = std::max(worst, std::asin(std::min(1.0, glm::length(glm::cross(glm::normalize(a), b)))) / kDegree);
    }
    std::printf("  %s: normals of up to %.0f degrees turn by at most %.4f\n", storage_encoding_name(GetParam()),
                tilt_max, worst);
    const double limit = GetParam() == StorageEncoding::kSnorm16 ? 0.02
                         : GetParam() == StorageEncoding::kHalf  ? 0.25
                                                                 : 1e-4;
    if (tilt_max <= 84.0) {
      EXPECT_LE(worst, limit);
    }
  }
}

TEST_P(FinestTest, RoundingAgainChangesNothing) {
  MovmfFinest once = random_finest(random_, 100, 30, 3, true);
  quantize_movmf(once, GetParam(), 1);
  MovmfFinest twice = once;
  quantize_movmf(twice, GetParam(), 3);
  EXPECT_EQ(twice.normals, once.normals);
  EXPECT_EQ(twice.colours, once.colours);
}

TEST_P(FinestTest, IsWhatLevelZeroOfAMipmapIsRoundedTo) {
  MovmfFinest rows = random_finest(random_, 33, 17, 3, true);
  MovmfMipmap mipmap;
  mipmap.header.encoding = GetParam();
  mipmap.levels.push_back(expand(rows, 3));
  quantize_movmf(mipmap, 2);
  quantize_movmf(rows, GetParam(), 1);
  const MovmfFinest found = finest_of(mipmap.levels[0], 0, 17);
  EXPECT_EQ(found.normals, rows.normals);
  EXPECT_EQ(found.lobe, rows.lobe);
  EXPECT_EQ(found.colours, rows.colours);
}

TEST(FinestRowsTest, ExpandAndBack) {
  std::mt19937 random(5);
  const MovmfFinest rows = random_finest(random, 21, 9, 4, true);
  const MovmfLevel level = expand(rows, 4);
  ASSERT_EQ(level.lobes.size(), 4u);
  for (std::size_t i = 0; i < rows.normals.size(); ++i)
    for (std::size_t j = 0; j < 4; ++j) {
      const bool given = rows.lobe[i] == j;
      ASSERT_EQ(level.lobes[j][i], given ? glm::vec4(rows.normals[i], 1.0f) : glm::vec4(0.0f));
      ASSERT_EQ(level.colours[j][i], given ? rows.colours[i] : glm::vec3(0.0f));
    }
  const MovmfFinest some = finest_of(level, 3, 4);
  EXPECT_EQ(some.height, 4);
  for (std::size_t i = 0; i < some.normals.size(); ++i) {
    ASSERT_EQ(some.normals[i], rows.normals[3 * 21 + i]);
    ASSERT_EQ(some.lobe[i], rows.lobe[3 * 21 + i]);
    ASSERT_EQ(some.colours[i], rows.colours[3 * 21 + i]);
  }
}

TEST(FinestDeathTest, WhatIsNoSingleDirectionWholeInOneLobe) {
  ::testing::FLAGS_gtest_death_test_style = "threadsafe";
  const MovmfFinest one{1, 1, {{0.0f, 0.0f, 1.0f}}, {1}, {}};
  const auto with = [&](std::size_t lobe, const glm::vec4& value) {
    MovmfLevel level = expand(one, 3);
    level.lobes[lobe][0] = value;
    return level;
  };
  EXPECT_EQ(finest_of(with(1, {0.6f, 0.0f, 0.8f, 1.0f}), 0, 1).lobe[0], 1);
  EXPECT_DEATH(finest_of(with(1, glm::vec4(0.0f)), 0, 1), "all_given");
  EXPECT_DEATH(finest_of(with(0, {0.0f, 0.0f, 1.0f, 1.0f}), 0, 1), "whole && alone");
  EXPECT_DEATH(finest_of(with(2, {0.0f, 0.0f, 1e-3f, 1e-3f}), 0, 1), "whole && alone");
  EXPECT_DEATH(finest_of(with(1, {0.0f, 0.0f, 0.5f, 1.0f}), 0, 1), "whole && alone");
  EXPECT_DEATH(finest_of(with(1, {0.6f, 0.0f, -0.8f, 1.0f}), 0, 1), "whole && alone");
}

}  // namespace
}  // namespace multum
