// SPDX-License-Identifier: Apache-2.0
// Settings are chosen by what a map needs; a mosaic is made of the map; and the interval of a measured error holds what
// all texels say.
#include "host/bake/setting_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "host/bake/map_mosaic.h"
#include "host/bake/movmf_bake.h"
#include "host/base/error.h"
#include "host/image/four_quarter_map.h"
#include "tests/reference/test_maps.h"

namespace multum {
namespace {

Device& test_device() {
  static Device device = Device::open("");
  return device;
}

BakeSource source_of(const NormalMap& map) { return {{planes_of(map), map.report}, std::nullopt, std::nullopt}; }

BakeJob job_on_two_threads() {
  BakeJob job;
  job.output = "unwritten.ndf.exr";
  return job;
}

SettingTrials trials_of(const BakeSource& source, const std::string& brdf,
                        std::optional<Representation> only = std::nullopt) {
  return {test_device(), job_on_two_threads(), source, parse_target_brdf(brdf), setting_candidates(only)};
}

std::string chosen(SettingTrials& trials, double error) {
  const std::optional<SettingTrial> trial = cheapest_within(trials, error, 1.0, 0, nullptr);
  return trial ? trials.candidates()[trial->candidate].options : "none";
}

TEST(SettingCandidates, ComeInTheOrderOfTheirCost) {
  const std::vector<SettingCandidate> all = setting_candidates(std::nullopt);
  ASSERT_GT(all.size(), 20u);
  for (std::size_t i = 1; i < all.size(); ++i)
    EXPECT_LE(std::pair(all[i - 1].texture_count, all[i - 1].effort), std::pair(all[i].texture_count, all[i].effort));
  EXPECT_EQ(all.front().options, "--ndf vmf --lobes 1 --sweeps 1 --no-rehearsal");
  for (const RepresentationInfo& info : representations()) {
    const std::vector<SettingCandidate> of_one = setting_candidates(info.representation);
    EXPECT_FALSE(of_one.empty()) << info.option;
    for (const SettingCandidate& one : of_one) {
      const BakeJob job = with_candidate(job_on_two_threads(), one);
      EXPECT_EQ(job.representation, info.representation);
      EXPECT_TRUE(one.options.starts_with(std::string("--ndf ") + info.option)) << one.options;
    }
  }
}

TEST(TargetBrdf, IsNamedAsRowsAre) {
  EXPECT_EQ(parse_target_brdf("blinn-phong:100").name, "blinn-phong:100");
  EXPECT_EQ(parse_target_brdf("blinn-phong:1e2").name, "blinn-phong:100");
  EXPECT_EQ(parse_target_brdf("blinn-phong:33.5").brdf.exponent, 33.5f);
  EXPECT_FALSE(parse_target_brdf("lambert").has_highlight());
  EXPECT_EQ(parse_target_brdf("ggx:0.4").name, "ggx:0.4");
  // What every bake measures is not measured again.
  EXPECT_TRUE(parse_target_brdf("blinn-phong:500").more_highlights().empty());
  EXPECT_EQ(parse_target_brdf("torrance-sparrow:0.1").more_highlights().size(), 1u);
  for (const char* text :
       {"", "phong", "blinn-phong", "blinn-phong:", "blinn-phong:0.5", "blinn-phong:nan", "blinn-phong:100x",
        "blinn-phong:2e5", "lambert:3", "ggx:0", "ggx:1.1", "torrance-sparrow:2"})
    EXPECT_THROW(parse_target_brdf(text), Error) << text;
}

// Every texel tells where it comes from.
NormalMap numbered_map(int width, int height) {
  return testing::make_map(width, height, [](int x, int y) { return glm::dvec3(x, y, 1.0); });
}

TEST(MapMosaic, OfASmallMapIsTheMap) {
  const NormalMap map = numbered_map(200, 256);
  const BakeSource mosaic = make_mosaic(source_of(map), {});
  ASSERT_EQ(mosaic.map.normals.width(), 200);
  ASSERT_EQ(mosaic.map.normals.height(), 256);
  for (int y = 0; y < 256; y += 5)
    for (int x = 0; x < 200; x += 3)
      EXPECT_EQ(mosaic.map.normals.texel(x, y)[0], map.x[static_cast<std::size_t>(y * 200 + x)]);
}

TEST(MapMosaic, HasABlockOfEveryCell) {
  constexpr int kWidth = 517, kHeight = 301, kBlock = 64, kCount = 4;
  const NormalMap map = numbered_map(kWidth, kHeight);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const BakeSource mosaic = make_mosaic(source_of(map), {256, kBlock, seed});
    ASSERT_EQ(mosaic.map.normals.width(), 256);
    ASSERT_EQ(mosaic.map.normals.height(), 256);
    for (int j = 0; j < kCount; ++j)
      for (int i = 0; i < kCount; ++i) {
        const auto [x, y, z] = mosaic.map.normals.texel(i * kBlock, j * kBlock);
        EXPECT_GE(x, kWidth * i / kCount - 1) << "seed " << seed;
        EXPECT_LE(x + kBlock, std::max(kWidth * (i + 1) / kCount, kWidth * i / kCount + kBlock));
        EXPECT_GE(y, kHeight * j / kCount - kBlock);
        EXPECT_LE(y + kBlock, kHeight);
        const auto last = mosaic.map.normals.texel((i + 1) * kBlock - 1, (j + 1) * kBlock - 1);
        EXPECT_EQ(last[0], x + kBlock - 1);
        EXPECT_EQ(last[1], y + kBlock - 1);
      }
  }
}

TEST(SettingChoice, TakesTheCheapestForAFlatMap) {
  const NormalMap map = testing::make_map(64, 64, [](int, int) { return glm::dvec3(0.0, 0.0, 1.0); });
  const BakeSource source = source_of(map);
  SettingTrials trials = trials_of(source, "blinn-phong:100");
  EXPECT_EQ(chosen(trials, 0.01), trials.candidates().front().options);
  EXPECT_EQ(trials.made().size(), 1u) << "more was tried than needed";
}

// What it takes, and no less: the four quarters have one, two and many directions.
TEST(SettingChoice, TakesMoreLobesAsTheErrorFalls) {
  const FourQuarterMap map = make_four_quarter_map(64, 7);
  const BakeSource source = source_of(map.normals);
  SettingTrials trials = trials_of(source, "blinn-phong:100", Representation::kMovmf);
  int before = 0;
  for (const double error : {0.9, 0.6, 0.2}) {
    const std::optional<SettingTrial> trial = cheapest_within(trials, error, 1.0, 0, nullptr);
    ASSERT_TRUE(trial.has_value()) << error;
    EXPECT_TRUE(trial->reached.meets(error));
    const int lobes = trials.candidates()[trial->candidate].texture_count;
    EXPECT_GT(lobes, before) << error;
    before = lobes;
    for (const SettingTrial& other : trials.made())
      EXPECT_TRUE(other.candidate >= trial->candidate || !other.reached.meets(error))
          << trials.candidates()[other.candidate].options;
    // What bakes took more than the trials promised is asked of them.
    const std::optional<SettingTrial> corrected = cheapest_within(trials, error, 1.5, 0, nullptr);
    EXPECT_TRUE(!corrected || corrected->candidate >= trial->candidate);
  }
  SettingTrials moments = trials_of(source, "blinn-phong:100", Representation::kMoments);
  EXPECT_EQ(chosen(moments, 0.2), "none");
}

// A diffuse surface needs less than a glossy one.
TEST(SettingChoice, DependsOnTheBrdf) {
  const FourQuarterMap map = make_four_quarter_map(128, 7);
  const BakeSource source = source_of(map.normals);
  SettingTrials diffuse = trials_of(source, "lambert"), glossy = trials_of(source, "blinn-phong:500");
  const std::optional<SettingTrial> a = cheapest_within(diffuse, 0.3, 1.0, 0, nullptr),
                                    b = cheapest_within(glossy, 0.3, 1.0, 0, nullptr);
  ASSERT_TRUE(a && b);
  EXPECT_LT(a->candidate, b->candidate);
}

TEST(AccuracySummary, IntervalHoldsTheErrorOfAllTexels) {
  constexpr int kSize = 128, kSeeds = 120;
  const FourQuarterMap map = make_four_quarter_map(kSize, 3);
  MovmfSettings fitting;
  fitting.lobe_count = 2;
  fitting.first_level = kSummaryLevel;
  BakeReport report;
  MovmfMipmap mipmap = bake_movmf(test_device(), map.normals, nullptr, fitting, report, nullptr);
  quantize_movmf(mipmap, 2);
  const PlaneStore normals = planes_of(map.normals);
  const auto measure = [&](std::int64_t samples, std::uint64_t seed) {
    AccuracySettings settings;
    settings.exponents = {100.0};
    settings.first_level = kSummaryLevel;
    settings.samples_per_level = samples;
    settings.seed = seed;
    MovmfMeter meter(mipmap, false, settings);
    for (int l = kSummaryLevel; l < static_cast<int>(mipmap.levels.size()); ++l)
      meter.add_rows(l, 0, mipmap.levels[static_cast<std::size_t>(l)]);
    const std::vector<AccuracyRow> rows = meter.run(test_device(), normals, nullptr, nullptr);
    EXPECT_EQ(meter.summaries().size(), 2u);
    return std::pair(meter.summaries().front(), rows);
  };
  const auto [whole, rows] = measure(0, 1);
  EXPECT_EQ(whole.brdf, "blinn-phong:100");
  EXPECT_EQ(whole.confidence, 0.0);
  // Each level weighs the same; their mean truth is the same but for borders.
  double sum = 0.0;
  for (const AccuracyRow& row : rows)
    if (row.brdf == whole.brdf && row.point == AccuracyPoint::kCentre) sum += row.error;
  EXPECT_NEAR(whole.error, sum / 6.0, 0.15 * whole.error);
  int held = 0;
  double width = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    const AccuracySummary sampled = measure(60, static_cast<std::uint64_t>(seed)).first;
    held += std::abs(sampled.error - whole.error) <= sampled.confidence ? 1 : 0;
    width += sampled.confidence / kSeeds;
  }
  // 95 % of 120 are 114, 2.4 off at a standard deviation; spreading samples evenly makes intervals wide, not narrow.
  EXPECT_GE(held, 107);
  EXPECT_LT(width, 0.25 * whole.error) << "so wide that it says nothing";
}

}  // namespace
}  // namespace multum
