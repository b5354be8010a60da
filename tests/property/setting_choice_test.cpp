// SPDX-License-Identifier: Apache-2.0
// Tests that the chosen settings suit the map, that a mosaic is made from the map, and that the interval of a measured
// error contains the error over all texels.
#include "host/bakes/settings_search/setting_choice.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <glm/geometric.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/bakes/bake/ndf_bake.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/bakes/settings_search/map_mosaic.h"
#include "host/formats/testmap/four_quarter_map.h"
#include "host/foundation/base/error.h"
#include "tests/fixtures/shared_data.h"
#include "tests/fixtures/test_device.h"
#include "tests/fixtures/test_maps.h"

namespace multum {
namespace {

using testing::test_device;

namespace fs = std::filesystem;

BakeSource source_of(const NormalMap& map) { return {{planes_of(map), map.report}, std::nullopt, std::nullopt}; }

BakeJob job_on_two_threads() {
  BakeJob job;
  job.output = "unwritten.ndf.exr";
  return job;
}

SettingTrials trials_of(const BakeSource& source, const std::string& brdf,
                        std::optional<Representation> only = std::nullopt) {
  return {test_device(), job_on_two_threads(), source, parse_target_brdf(brdf), target_candidates(only)};
}

std::string chosen(SettingTrials& trials, double error) {
  const std::optional<SettingTrial> trial = cheapest_within(trials, error, 1.0, 0, nullptr);
  return trial ? trials.candidates()[trial->candidate].options : "none";
}

TEST(SettingCandidates, ComeInTheOrderOfTheirCost) {
  const std::vector<SettingCandidate> all = target_candidates(std::nullopt);
  ASSERT_GT(all.size(), 20u);
  for (std::size_t i = 1; i < all.size(); ++i)
    EXPECT_LE(std::pair(all[i - 1].texture_count, all[i - 1].effort), std::pair(all[i].texture_count, all[i].effort));
  EXPECT_EQ(all.front().options, "--ndf vmf --lobes 1 --passes 1 --no-start-search");
  for (const RepresentationInfo& info : representations()) {
    const std::vector<SettingCandidate> of_one = target_candidates(info.representation);
    EXPECT_FALSE(of_one.empty()) << info.option;
    for (const SettingCandidate& one : of_one) {
      const BakeJob job = with_candidate(job_on_two_threads(), one);
      EXPECT_EQ(job.representation, info.representation);
      EXPECT_TRUE(one.options.starts_with(std::string("--ndf ") + info.option)) << one.options;
    }
  }
}

TEST(TargetBrdf, IsNamedAsRowsAre) {
  EXPECT_EQ(parse_target_brdf("blinn-phong:100").id.text(), "blinn-phong:100");
  EXPECT_EQ(parse_target_brdf("blinn-phong:1e2").id.text(), "blinn-phong:100");
  EXPECT_EQ(parse_target_brdf("blinn-phong:33.5").brdf.exponent, 33.5f);
  EXPECT_FALSE(parse_target_brdf("lambert").has_highlight());
  EXPECT_EQ(parse_target_brdf("ggx:0.4").id.text(), "ggx:0.4");
  EXPECT_EQ(parse_target_brdf("charlie:0.6").id.text(), "charlie:0.6");
  // A highlight that every bake measures is not measured again.
  EXPECT_TRUE(parse_target_brdf("blinn-phong:500").more_highlights().empty());
  EXPECT_EQ(parse_target_brdf("torrance-sparrow:0.1").more_highlights().size(), 1u);
  for (const char* text :
       {"", "phong", "blinn-phong", "blinn-phong:", "blinn-phong:0.5", "blinn-phong:nan", "blinn-phong:100x",
        "blinn-phong:2e5", "lambert:3", "ggx:0", "ggx:1.1", "torrance-sparrow:2", "charlie:0.59", "charlie:0.5,0.04"})
    EXPECT_THROW(parse_target_brdf(text), Error) << text;
}

// The value of every texel encodes its position.
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
  constexpr int kMapWidth = 517, kMapHeight = 301, kBlock = 64, kCount = 4;
  const NormalMap map = numbered_map(kMapWidth, kMapHeight);
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    const BakeSource mosaic = make_mosaic(source_of(map), {256, kBlock, seed});
    ASSERT_EQ(mosaic.map.normals.width(), 256);
    ASSERT_EQ(mosaic.map.normals.height(), 256);
    for (int j = 0; j < kCount; ++j)
      for (int i = 0; i < kCount; ++i) {
        const auto [x, y, z] = mosaic.map.normals.texel(i * kBlock, j * kBlock);
        EXPECT_GE(x, kMapWidth * i / kCount - 1) << "seed " << seed;
        EXPECT_LE(x + kBlock, std::max(kMapWidth * (i + 1) / kCount, kMapWidth * i / kCount + kBlock));
        EXPECT_GE(y, kMapHeight * j / kCount - kBlock);
        EXPECT_LE(y + kBlock, kMapHeight);
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
  EXPECT_EQ(trials.made().size(), 1u) << "more settings were tried than needed";
}

// The search must choose as many lobes as needed and no more. The four quarters have one direction, two directions, or
// many directions.
TEST(SettingChoice, TakesMoreLobesAsTheErrorFalls) {
  const FourQuarterMap map = make_four_quarter_map(64, 7);
  const BakeSource source = source_of(map.normals);
  SettingTrials trials = trials_of(source, "blinn-phong:100", Representation::kMovmf);
  int before = 0;
  for (const double error : {0.9, 0.6, 0.3}) {
    const std::optional<SettingTrial> trial = cheapest_within(trials, error, 1.0, 0, nullptr);
    ASSERT_TRUE(trial.has_value()) << error;
    EXPECT_TRUE(trial->reached.meets(error));
    const int lobes = trials.candidates()[trial->candidate].texture_count;
    EXPECT_GT(lobes, before) << error;
    before = lobes;
    for (const SettingTrial& other : trials.made())
      EXPECT_TRUE(other.candidate >= trial->candidate || !other.reached.meets(error))
          << trials.candidates()[other.candidate].options;
    // If earlier bakes had higher errors than their trials, the search requires trials with errors that are lower by
    // the same factor.
    const std::optional<SettingTrial> corrected = cheapest_within(trials, error, 1.5, 0, nullptr);
    EXPECT_TRUE(!corrected || corrected->candidate >= trial->candidate);
  }
  SettingTrials moments = trials_of(source, "blinn-phong:100", Representation::kMoments);
  EXPECT_EQ(chosen(moments, 0.2), "none");
}

// A diffuse surface needs fewer lobes than a glossy one.
TEST(SettingChoice, DependsOnTheBrdf) {
  const FourQuarterMap map = make_four_quarter_map(128, 7);
  const BakeSource source = source_of(map.normals);
  SettingTrials diffuse = trials_of(source, "lambert"), glossy = trials_of(source, "blinn-phong:500");
  const std::optional<SettingTrial> a = cheapest_within(diffuse, 0.6, 1.0, 0, nullptr),
                                    b = cheapest_within(glossy, 0.6, 1.0, 0, nullptr);
  ASSERT_TRUE(a && b);
  EXPECT_LT(a->candidate, b->candidate);
}

// Returns the middle of a map, as wide and high as the generated maps.
NormalMap middle_of(const NormalMap& map, int size) {
  NormalMap part;
  part.width = part.height = size;
  const int x0 = (map.width - size) / 2, y0 = (map.height - size) / 2;
  for (int y = y0; y < y0 + size; ++y)
    for (int x = x0; x < x0 + size; ++x) {
      const auto i = static_cast<std::size_t>(y) * static_cast<std::size_t>(map.width) + static_cast<std::size_t>(x);
      part.x.push_back(map.x[i]);
      part.y.push_back(map.y[i]);
      part.z.push_back(map.z[i]);
    }
  return part;
}

// Returns the four-quarter map, each of its quarters, and the first real maps if their folder exists.
std::vector<std::pair<std::string, NormalMap>> maps_to_measure(int size) {
  std::vector<std::pair<std::string, NormalMap>> maps = {{"all quarters", make_four_quarter_map(size, 3).normals}};
  for (const auto& [name, quarter] : kQuarters)
    maps.emplace_back(name, make_four_quarter_map(size, 3, quarter).normals);
  if (testing::shared_data().empty()) return maps;
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(testing::shared_data() + "/normal"))
    if (entry.path().stem().string().ends_with("_normal")) files.insert(entry.path().string());
  constexpr std::size_t kRealMaps = 3;
  while (files.size() > kRealMaps) files.erase(std::prev(files.end()));
  for (const std::string& file : files)
    maps.emplace_back(fs::path(file).filename(), middle_of(read_normal_map(file, {}, 2, nullptr), size));
  return maps;
}

// Returns the number of successes that `count` trials reach in all but one of 10,000 cases, if each trial succeeds with
// a probability of 95 %. A binomial sum gives this number.
int least_held(int count) {
  double below = 0.0;
  for (int held = 0; held < count; ++held) {
    below += std::exp(std::lgamma(count + 1.0) - std::lgamma(held + 1.0) - std::lgamma(count - held + 1.0) +
                      held * std::log(0.95) + (count - held) * std::log(0.05));
    if (below > 1e-4) return held;
  }
  return count;
}

// The measured footprints of a map represent all of its footprints. Errors in units of the standard error have a mean
// square of 1 if the interval is right. The mean square is lower if evenly spread footprints represent the map better
// than the interval assumes. The coverage reveals intervals that are only half as wide as they should be on one map, or
// a fifth too narrow on all maps. The mean square also reveals intervals that are one and a half times as wide as they
// should be. `multum-bench coverage` has every real map and setting.
TEST(FootprintErrors, IntervalHoldsTheErrorOfAllFootprints) {
  constexpr int kSize = 64, kSeeds = 60, kFew = 48;
  int held_of_all = 0, all = 0;
  double squares = 0.0;
  for (const auto& [name, map] : maps_to_measure(kSize)) {
    SCOPED_TRACE(name);
    MovmfSettings fitting;
    fitting.lobe_count = 2;
    fitting.search_start = false;
    FitReport report;
    MovmfMipmap mipmap = bake_movmf(test_device(), map, nullptr, fitting, report, nullptr);
    quantize_movmf(mipmap, 2);
    const PlaneStore normals = planes_of(map);
    AccuracySettings settings;
    settings.exponents = {100.0};
    settings.has_level_table = false;
    settings.footprints_per_octave = kFew;
    settings.replicates = kSeeds;
    MovmfMeter meter(mipmap, false, settings);
    for (int l = 0; l < static_cast<int>(mipmap.levels.size()); ++l)
      meter.add_rows(l, 0, mipmap.levels[static_cast<std::size_t>(l)]);
    EXPECT_TRUE(meter.run(test_device(), normals, nullptr, nullptr).empty()) << "no table was requested";
    ASSERT_EQ(meter.footprint_errors().size(), 2u);
    const FootprintError whole = meter.footprint_errors().front();
    EXPECT_EQ(whole.brdf, AccuracyBrdf::blinn_phong(100.0));
    int count = 0;
    for (int k = 0; k < footprint_octave_count(kSize, kSize); ++k) count += footprint_count(k, kSize, kSize, kFew);
    EXPECT_EQ(whole.sample_count, kSeeds * count);
    ASSERT_EQ(meter.replicate_errors().size(), static_cast<std::size_t>(kSeeds));
    int held = 0;
    double width = 0.0;
    for (const std::vector<FootprintError>& one : meter.replicate_errors()) {
      const FootprintError& sampled = one.front();
      // The error over all footprints includes this sample, which reduces the difference by the factor sqrt(1 - 1 / n).
      const double off = (sampled.error - whole.error) / std::sqrt(1.0 - 1.0 / kSeeds);
      held += std::abs(off) <= sampled.confidence ? 1 : 0;
      width += sampled.confidence / kSeeds;
      squares += std::pow(off / sampled.confidence * 1.96, 2.0);
    }
    EXPECT_GE(held, least_held(kSeeds));
    EXPECT_LT(width, 0.25 * whole.error) << "the interval is too wide to be useful";
    held_of_all += held;
    all += kSeeds;
  }
  EXPECT_GE(held_of_all, least_held(all));
  // The mean of `all` squared standard normal values has a standard error of sqrt(2 / all). Four standard errors are
  // allowed.
  EXPECT_LT(squares / all, 1.0 + 4.0 * std::sqrt(2.0 / all));
  EXPECT_GT(squares / all, 0.4);
}

// If all normals of the map are equal, every pixel shows f(n . h) max(n . l, 0), whatever it covers. If the stored
// value is filtered and shaded with the cosine, it equals the reference, except for rounding to 16-bit floats and to
// 16-bit integers.
TEST(FootprintErrors, OfOneNormalAreNothing) {
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.4, -0.3, 0.8));
  const NormalMap map =
      testing::make_map(24, 10, [&](int, int) { return normal; });  // kept alive here, because the source refers to it
  const BakeSource source = source_of(map);
  for (const Representation representation : {Representation::kMovmf, Representation::kMoments}) {
    BakeJob job = job_on_two_threads();
    job.representation = representation;
    if (representation == Representation::kMoments) job.encoding = StorageEncoding::kHalf;
    job.fitting.lobe_count = 1;
    AccuracySettings settings;
    settings.exponents = {20.0, 100.0};
    settings.footprints_per_octave = 16;
    BakeReport report;
    const auto meter = try_levels(test_device(), job, source, settings, report, nullptr);
    meter->run(test_device(), source.map.normals, nullptr, nullptr);
    bool is_any = false;
    for (const FootprintError& one : meter->footprint_errors()) {
      if (one.brdf.shading.starts_with("lean")) continue;  // a Gaussian has a different highlight
      is_any = true;
      EXPECT_LT(one.error, 1e-2) << one.brdf.text();
      EXPECT_LT(one.percentile_95, 1e-2) << one.brdf.text();
    }
    EXPECT_TRUE(is_any);
  }
}

}  // namespace
}  // namespace multum
