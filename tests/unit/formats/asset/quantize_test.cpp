// SPDX-License-Identifier: Apache-2.0
// Tests the rounding of lobes. Sums stay 1, single directions stay single, and spreads are kept for a kappa of up to
// storage_kappa_max. A glossy highlight on a tilted flat surface keeps its peak, both at texels and between them.
#include <gtest/gtest.h>
#include <half.h>

#include <array>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/lab/reference/movmf_rounding.h"
#include "tests/unit/formats/asset/movmf_test_mipmap.h"

namespace multum {
namespace {

using testing::kDegree;
using testing::random_direction;
using testing::random_shares;
using testing::stored_lobe;
using testing::uniform;

// Rounds texels that have several lobes each, as if they were one level that is not the finest level. texels[i][j] is
// lobe j of texel i.
void quantize(std::vector<std::vector<glm::vec4>>& texels, StorageEncoding encoding) {
  MovmfLevel level;
  level.width = static_cast<int>(texels.size());
  level.height = 1;
  level.lobes.assign(texels[0].size(), std::vector<glm::vec4>(texels.size()));
  for (std::size_t i = 0; i < texels.size(); ++i)
    for (std::size_t j = 0; j < texels[i].size(); ++j) level.lobes[j][i] = texels[i][j];
  quantize_movmf(level, encoding, 1);
  for (std::size_t i = 0; i < texels.size(); ++i)
    for (std::size_t j = 0; j < texels[i].size(); ++j) texels[i][j] = level.lobes[j][i];
}

class QuantizeTest : public ::testing::TestWithParam<StorageEncoding> {
 protected:
  const unsigned seed_ = 11;
  std::mt19937 random_{seed_};
  const ::testing::ScopedTrace trace_{__FILE__, __LINE__, "seed " + std::to_string(seed_)};
};
INSTANTIATE_TEST_SUITE_P(Encodings, QuantizeTest, ::testing::Values(StorageEncoding::kSnorm16, StorageEncoding::kHalf));

TEST_P(QuantizeTest, ValuesAreOnTheGrid) {
  std::vector<std::vector<glm::vec4>> texels;
  for (int i = 0; i < 2000; ++i) {
    texels.emplace_back();
    for (const double share : random_shares(random_, 4))
      texels.back().push_back(stored_lobe(share, uniform(random_) * random_direction(random_, 90 * kDegree)));
  }
  quantize(texels, GetParam());
  for (const auto& lobes : texels)
    for (const glm::vec4& lobe : lobes)
      for (int c = 0; c < 4; ++c) {
        if (GetParam() == StorageEncoding::kHalf) {
          ASSERT_EQ(static_cast<float>(half(lobe[c])), lobe[c]);
        } else {
          // The GPU decodes the nearest 16-bit code to exactly this float.
          const double steps = std::round(static_cast<double>(lobe[c]) * 32767.0);
          ASSERT_EQ(static_cast<float>(steps) / 32767.0f, lobe[c]);
        }
      }
}

// Makes lobes of every kind: single, wide, flat, already rounded, or of almost no amplitude.
std::vector<std::vector<glm::vec4>> lobes_of_every_kind(std::mt19937& random, int count, int texel_count) {
  std::vector<std::vector<glm::vec4>> texels;
  for (int i = 0; i < texel_count; ++i) {
    texels.emplace_back();
    for (double share : random_shares(random, count)) {
      glm::dvec3 r = random_direction(random, 90 * kDegree);
      switch (random() % 8) {
        case 0: r = glm::dvec3(glm::vec3(r)); break;    // a single direction in float
        case 1: r = glm::dvec3(0.0, 0.0, 1.0); break;   // flat
        case 2: r = glm::dvec3(r.x, -r.y, 0.0); break;  // in a plane
        case 3: r = glm::dvec3(0.0); break;             // no direction
        case 4:
          share = std::round(share * 32767.0) / 32767.0;
          r *= 0.5;
          break;                                                     // ties
        case 5: r = glm::round(r * 16384.0) / 32767.0; break;        // already rounded if the share is 1
        default: r *= 1.0 - std::pow(10.0, -7.0 * uniform(random));  // every sharpness
      }
      texels.back().push_back(stored_lobe(share, r));
    }
  }
  return texels;
}

TEST_P(QuantizeTest, RoundsAsTheReferenceDoes) {
  std::size_t different = 0;
  for (int count = 1; count <= 8; ++count) {
    std::vector<std::vector<glm::vec4>> texels = lobes_of_every_kind(random_, count, 200000 / count);
    std::vector<std::vector<glm::vec4>> expected;
    for (const auto& lobes : texels) expected.push_back(reference::round_texel(lobes, GetParam()));
    quantize(texels, GetParam());
    for (std::size_t i = 0; i < texels.size(); ++i)
      if (texels[i] != expected[i] && ++different <= 5) ADD_FAILURE() << count << " lobes, texel " << i;
  }
  EXPECT_EQ(different, 0u);
}

TEST(QuantizeStepsTest, StepsAreTheirQuotients) {
  // movmf_quantize.cpp multiplies by this reciprocal.
  for (int k = -32768; k <= 32768; ++k)
    ASSERT_EQ(static_cast<float>(k * (1.0 / 32767.0)), static_cast<float>(k / 32767.0)) << k;
}

TEST_P(QuantizeTest, AmplitudesSumToOne) {
  for (int count = 1; count <= 8; ++count) {
    std::vector<std::vector<glm::vec4>> texels;
    for (int i = 0; i < 2000; ++i) {
      texels.emplace_back();
      for (const double share : random_shares(random_, count))
        texels.back().push_back(stored_lobe(share, random_direction(random_, 90 * kDegree)));
    }
    const auto before = texels;
    quantize(texels, GetParam());
    for (std::size_t i = 0; i < texels.size(); ++i) {
      double steps = 0.0, sum = 0.0;
      for (std::size_t j = 0; j < texels[i].size(); ++j) {
        const auto a = static_cast<double>(texels[i][j].w);
        steps += std::round(a * 32767.0);
        sum += a;
        ASSERT_GE(a, 0.0);
        // No value changes by a whole step, or by more than half a unit in the last place of a 16-bit float.
        const double limit = GetParam() == StorageEncoding::kSnorm16 ? 1.0 / 32767.0 : std::max(a, 6e-5) / 2048.0;
        ASSERT_LE(std::abs(a - static_cast<double>(before[i][j].w)), limit + 1e-7);
      }
      if (GetParam() == StorageEncoding::kSnorm16) {
        ASSERT_EQ(steps, 32767.0);
        ASSERT_NEAR(sum, 1.0, 2e-7);
      } else {
        ASSERT_NEAR(sum, 1.0, 1.0 / 2048.0);
      }
    }
  }
}

TEST_P(QuantizeTest, SingleDirectionsNeverLoseLength) {
  std::vector<std::vector<glm::vec4>> texels;
  for (int i = 0; i < 20000; ++i) {
    texels.emplace_back();
    // Directions of every third texel are flat or in a coordinate plane. One of their values is exactly 0, so rounding
    // it up or down gives the same value.
    for (const double share : random_shares(random_, 4)) {
      glm::dvec3 n = random_direction(random_, 90 * kDegree);
      if (i % 3 == 0) n = glm::normalize(glm::dvec3(i % 2 == 0 ? 0.0 : n.x, 0.0, n.z + 1e-3));
      texels.back().push_back(stored_lobe(share, glm::dvec3(glm::vec3(n))));
    }
  }
  quantize(texels, GetParam());
  for (const auto& lobes : texels)
    for (const glm::vec4& lobe : lobes)
      ASSERT_GE(glm::length(glm::dvec3(lobe)), static_cast<double>(lobe.w)) << lobe.x << " " << lobe.y << " " << lobe.z;
}

TEST_P(QuantizeTest, EmptyLobesAreZero) {
  std::vector<std::vector<glm::vec4>> texels = {{{0, 0, 1, 1}, {0, 0, 0, 0}, {1e-9f, 0, 0, 1e-9f}}};
  quantize(texels, GetParam());
  EXPECT_EQ(texels[0][0], glm::vec4(0, 0, 1, 1));
  EXPECT_EQ(texels[0][1], glm::vec4(0));
  EXPECT_EQ(texels[0][2], glm::vec4(0));
}

// Holds the median and the 95th percentile of the relative change of the spread 1 - |r|, for lobes of amplitude 1 and a
// given kappa.
struct SpreadChange {
  double median, percentile_95;
};
SpreadChange spread_change(double kappa, StorageEncoding encoding, std::mt19937& random, double tilt_max) {
  const double spread = 1.0 / kappa;
  std::vector<std::vector<glm::vec4>> texels;
  for (int i = 0; i < 4000; ++i)
    texels.push_back({glm::vec4(glm::vec3((1.0 - spread) * random_direction(random, tilt_max)), 1.0f)});
  std::vector<double> before, changes;
  for (const auto& lobes : texels) before.push_back(1.0 - glm::length(glm::dvec3(lobes[0])));
  quantize(texels, encoding);
  for (std::size_t i = 0; i < texels.size(); ++i)
    changes.push_back(std::abs(1.0 - std::min(1.0, glm::length(glm::dvec3(texels[i][0]))) - before[i]) / spread);
  std::sort(changes.begin(), changes.end());
  return {changes[changes.size() / 2], changes[changes.size() * 95 / 100]};
}

TEST_P(QuantizeTest, KeepsSpreadUpToKappaMax) {
  const auto limit = static_cast<double>(storage_kappa_max(GetParam()));
  for (double kappa = limit; kappa > 5.0; kappa /= 2.0) {
    const SpreadChange change = spread_change(kappa, GetParam(), random_, 60 * kDegree);
    EXPECT_LE(change.percentile_95, 0.25) << "kappa " << kappa << ", median " << change.median;
  }
  for (double kappa : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0}) {
    const SpreadChange change = spread_change(kappa * limit, GetParam(), random_, 60 * kDegree);
    std::printf("  kappa %8.0f: the spread changes by %.3f (median), %.3f (95 %%)\n", kappa * limit, change.median,
                change.percentile_95);
  }
  // A flat lobe rounds only z, by at most half a step.
  for (double kappa = limit; kappa > 0.9 * limit; kappa *= 0.997)
    EXPECT_LE(spread_change(kappa, GetParam(), random_, 0.0).percentile_95, 0.31) << "flat, kappa " << kappa;
  // Far beyond the limit the error is large, so the limit is tight.
  EXPECT_GE(spread_change(4.0 * limit, GetParam(), random_, 60 * kDegree).percentile_95, 0.25);
}

// Returns the peak of the highlight over filtered lobes for a BRDF with mean cosine 1 - 1/kappa_f, shaded as in the
// runtime. Mean cosines multiply, |r| is clamped to 1, and the result is a vMF lobe (kappa = 1/(1 - A), A near 1). The
// peak over all half vectors is found by mean shift from the mean normal.
double highlight_peak(const std::vector<glm::dvec4>& lobes, double kappa_f) {
  struct Part {
    double amplitude, kappa;
    glm::dvec3 mu;
  };
  std::vector<Part> parts;
  glm::dvec3 at(0.0);
  for (const glm::dvec4& lobe : lobes) {
    if (!(lobe.w > 0.0)) continue;
    const double length = glm::length(glm::dvec3(lobe));
    const double mean = std::min(1.0, length / lobe.w) * (1.0 - 1.0 / kappa_f);
    parts.push_back({lobe.w, 1.0 / (1.0 - mean), glm::dvec3(lobe) / length});
    at += glm::dvec3(lobe);
  }
  at = glm::normalize(at);
  double value = 0.0;
  for (int step = 0; step < 20; ++step) {
    glm::dvec3 next(0.0);
    value = 0.0;
    for (const Part& part : parts) {
      const glm::dvec3 d = part.mu - at;
      const double density =
          part.amplitude * part.kappa / (2.0 * std::numbers::pi) * std::exp(-part.kappa * 0.5 * glm::dot(d, d));
      value += density;
      next += density * part.kappa * part.mu;
    }
    at = glm::normalize(next);
  }
  return value;
}

TEST_P(QuantizeTest, AGlossyHighlightOnATiltedFlatKeepsItsPeakAtTexelsAndBetweenThem) {
  // A roughness of 0.1 gives alpha = 0.01 and kappa_f = 2 / alpha^2.
  constexpr double kKappaF = 20000.0;
  const double exact = highlight_peak({{0.0, 0.0, 1.0, 1.0}}, kKappaF);
  EXPECT_NEAR(exact, kKappaF / (2.0 * std::numbers::pi), 1e-6 * exact);
  std::array<double, 2> worst = {0.0, 0.0};  // at texels and between them
  for (double tilt = 0.0; tilt <= 60.0; tilt += 2.5)
    for (double azimuth = 0.0; azimuth < 360.0; azimuth += tilt == 0.0 ? 360.0 : 3.7) {
      const double t = tilt * kDegree, p = azimuth * kDegree;
      const glm::dvec3 n(std::sin(t) * std::cos(p), std::sin(t) * std::sin(p), std::cos(t));
      std::vector<std::vector<glm::vec4>> texels;
      for (int i = 0; i < 4; ++i) {
        texels.emplace_back();
        for (const double share : random_shares(random_, 4))
          texels.back().push_back(stored_lobe(share, glm::dvec3(glm::vec3(n))));
      }
      quantize(texels, GetParam());
      const double s = uniform(random_), v = uniform(random_);
      const std::array<double, 4> weights = {(1 - s) * (1 - v), s * (1 - v), (1 - s) * v, s * v};
      std::vector<glm::dvec4> between(4, glm::dvec4(0.0));
      for (std::size_t i = 0; i < 4; ++i) {
        std::vector<glm::dvec4> lobes(texels[i].begin(), texels[i].end());
        worst[0] = std::max(worst[0], std::abs(highlight_peak(lobes, kKappaF) / exact - 1.0));
        for (std::size_t j = 0; j < 4; ++j) between[j] += weights[i] * lobes[j];
      }
      worst[1] = std::max(worst[1], std::abs(highlight_peak(between, kKappaF) / exact - 1.0));
    }
  std::printf("  %s: the peak changes by at most %.2f %% at texels, %.2f %% between them\n",
              storage_encoding_name(GetParam()), worst[0] * 100.0, worst[1] * 100.0);
  EXPECT_LE(worst[0], 0.02);
  EXPECT_LE(worst[1], 0.02);
}

// Counts lobes that are sharper than the storage format can represent, except for single directions. Storage as floats
// does not lose any.
TEST_P(QuantizeTest, SharpLobesAreCounted) {
  const auto limit = static_cast<double>(storage_kappa_max(GetParam()));
  MovmfLevel level;
  level.width = 7;
  level.height = 1;
  const glm::dvec3 mu = random_direction(random_, 60 * kDegree);
  const auto of_kappa = [&](double a, double kappa) { return stored_lobe(a, (1.0 - 1.0 / kappa) * mu); };
  level.lobes = {{of_kappa(1.0, 2.0 * limit), of_kappa(0.25, 1.1 * limit), of_kappa(1.0, 0.9 * limit),
                  of_kappa(1.0, 5.0), stored_lobe(1.0, mu), of_kappa(1e-5, 2.0 * limit), stored_lobe(0.0, mu)},
                 {stored_lobe(0.0, mu), of_kappa(0.75, 1.2 * limit), stored_lobe(0.0, mu), stored_lobe(0.0, mu),
                  stored_lobe(0.0, mu), of_kappa(1.0, 9.0), of_kappa(1.0, 9.0)}};
  for (const int threads : {1, 3}) {
    const SharpLobes sharp = count_sharp_lobes(level, GetParam(), threads);
    EXPECT_EQ(sharp.count, 3u) << "two from the first lobes, one from the second";
    EXPECT_DOUBLE_EQ(sharp.amplitude, 2.0);
  }
  EXPECT_EQ(count_sharp_lobes(level, StorageEncoding::kFloat, 1).count, 0u);
}

TEST(QuantizeFloatTest, FloatIsLeftAsItIs) {
  std::mt19937 random(1);
  std::vector<std::vector<glm::vec4>> texels = {
      {stored_lobe(0.3, random_direction(random, 1.0)), stored_lobe(0.7, 0.5 * random_direction(random, 1.0))}};
  const auto before = texels;
  quantize(texels, StorageEncoding::kFloat);
  EXPECT_EQ(texels, before);
}

}  // namespace
}  // namespace multum
