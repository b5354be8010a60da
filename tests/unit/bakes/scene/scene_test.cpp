// SPDX-License-Identifier: Apache-2.0
// Tests scenes. Each error message must name its line. Compares the survey of a map with sums over its texels, and
// estimates of lobes with known results. Also tests which levels are visible, and the plans for generated maps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <random>

#include "host/bakes/accuracy/accuracy.h"
#include "host/bakes/movmf/movmf_bake.h"
#include "host/bakes/scene/lobe_errors.h"
#include "host/bakes/scene/plan_text.h"
#include "host/bakes/scene/scene_plan.h"
#include "host/bakes/scene/seen_levels.h"
#include "host/formats/asset/baked_file.h"
#include "host/lab/reference/shading.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

const std::string kScene =
    "[camera]\n"
    "fov = 60\n"
    "resolution = [320, 240]\n"
    "[budget]\n"
    "estimate_margin = 0.05\n"
    "[[map]]\n"
    "name = \"wall\"\n"
    "normal = \"wall.exr\"\n"
    "green = \"up\"\n"
    "[[material]]\n"
    "name = \"paint\"\n"
    "brdf = \"blinn-phong\"\n"
    "exponent = [20, 100]\n"
    "[[object]]\n"
    "name = \"front\"\n"
    "map = \"wall\"\n"
    "material = \"paint\"\n"
    "width = 2.0\n"
    "distance = [1, 20]\n"
    "[[light]]\n"
    "direction = [0.3, 0.8, 0.5]\n";

std::string with(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class SceneTest : public ::testing::Test {
 protected:
  // The file must exist, but its content does not matter.
  SceneTest() { write_bytes(folder_ / "wall.exr", ""); }
  SceneDescription read(const std::string& text) const {
    write_bytes(path(), text);
    return read_scene(path(), pattern_);
  }
  std::string path() const { return folder_ / "scene.toml"; }
  /// Writes wall.exr with signed normals.
  void write_map(int size, const std::function<glm::dvec3(int x, int y)>& normal) {
    TestImage image{size, size, 3, std::vector<float>(static_cast<std::size_t>(3 * size * size))};
    image.type = OIIO::TypeDesc::FLOAT;
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const glm::dvec3 n = glm::normalize(normal(x, y));
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(n[c]);
      }
    write_test_image(folder_ / "wall.exr", image);
    pattern_.hashes = BakeJob().hashes;  // a job compares its inputs with the hashes that it computed at the start
  }
  ScenePlan plan(const std::string& text) const { return plan_scene(read(text), {2}, nullptr); }
  static const PlannedEffect& effect(const std::vector<PlannedEffect>& effects, std::string_view name) {
    const auto found =
        std::find_if(effects.begin(), effects.end(), [&](const PlannedEffect& e) { return e.effect == name; });
    EXPECT_NE(found, effects.end()) << name;
    return *found;
  }

  TemporaryFolder folder_;
  BakeJob pattern_;
};

TEST_F(SceneTest, IsRead) {
  const SceneDescription scene = read(kScene);
  EXPECT_EQ(scene.camera.width, 320);
  EXPECT_EQ(scene.camera.fov_degrees, 60.0);
  EXPECT_EQ(scene.budget.estimate_margin, 0.05);
  EXPECT_EQ(read(with(kScene, "estimate_margin = 0.05", "estimate_margin = 0.04")).budget.estimate_margin, 0.04);
  ASSERT_EQ(scene.maps.size(), 1u);
  EXPECT_EQ(scene.maps[0].job.input, folder_ / "wall.exr");
  EXPECT_EQ(scene.maps[0].job.reading.green, GreenAxis::kUp);
  ASSERT_EQ(scene.materials[0].brdfs.size(), 2u);
  EXPECT_EQ(scene.materials[0].brdfs[0].exponent, 20.0f);
  EXPECT_EQ(scene.materials[0].brdfs[1].exponent, 100.0f);
  EXPECT_EQ(scene.objects[0].distance_max, 20.0);
  EXPECT_EQ(scene.lights.size(), 1u);
}

// multum-view draws up to eight lights of each kind.
TEST_F(SceneTest, HasUpToEightLightsOfAKind) {
  const std::string light = "[[light]]\ndirection = [0.1, 0.2, 0.5]\n";
  std::string text = kScene;
  for (int i = 0; i < 7; ++i) text += light;
  EXPECT_EQ(read(text).lights.size(), 8u);
  expect_error(ErrorCode::kInput, {path(), "light", "more than 8 lights"}, [&] { read(text + light); });
}

TEST_F(SceneTest, WhatIsWrongIsRefusedWithItsLine) {
  struct Case {
    const char *from, *to;
    int line;
    std::vector<std::string> parts;
  };
  const Case cases[] = {
      {"fov = 60", "fow = 60", 2, {"camera.fow", "unknown key", "camera.fov"}},
      {"fov = 60", "fov = 200", 2, {"camera.fov", "200", "1 to 170"}},
      {"resolution = [320, 240]", "resolution = [320]", 3, {"camera.resolution", "[1920, 1080]"}},
      {"estimate_margin = 0.05", "estimate_margin = 0", 5, {"budget.estimate_margin", "0"}},
      {"estimate_margin = 0.05", "target_error = -1", 5, {"budget.target_error", "-1", "above 0"}},
      {"name = \"wall\"", "name = \"../wall\"", 7, {"map.name", "\"../wall\"", "letters"}},
      {"normal = \"wall.exr\"\n", "", 6, {"map", "no normal"}},
      {"normal = \"wall.exr\"", "normal = \"wal.exr\"", 8, {"map.normal is ", "wal.exr", "an existing file"}},
      {"normal = \"wall.exr\"", "normal = \".\"", 8, {"map.normal", "a folder", "a file"}},
      {"green = \"up\"", "albedo = \"no.png\"", 9, {"map.albedo is ", "no.png", "an existing file"}},
      {"green = \"up\"", "roughness = \"no.png:G\"", 9, {"map.roughness is ", "no.png", "expected"}},
      {"direction = [0.3, 0.8, 0.5]",
       "direction = [0, 0, 1]\n[environment]\nfile = \"sky.exr\"",
       23,
       {"environment.file is "}},
      {"distance = [1, 20]", "distance = 1e300", 19, {"object.distance", "1e+300", "1e-6 to 1e9"}},
      {"[[material]]",
       "[[map]]\nname = \"other\"\nnormal = \"wall.exr\"\n[[material]]",
       11,
       {"map.name", "\"other\"", "not used by any [[object]]"}},
      {"green = \"up\"", "green = \"left\"", 9, {"map.green", "\"left\"", "up, down"}},
      {"brdf = \"blinn-phong\"", "brdf = \"phong\"", 12, {"material.brdf", "\"phong\"", "lambert, blinn-phong"}},
      {"exponent = [20, 100]", "exponent = [100, 20]", 13, {"material.exponent is [100, 20]", "lower", "first"}},
      {"exponent = [20, 100]", "exponent = 0.5", 13, {"material.exponent", "0.5", "1 to 100000"}},
      {"exponent = [20, 100]", "sigma = 0.1", 13, {"material.sigma", "\"torrance-sparrow\"", "\"cook-torrance\""}},
      {"exponent = [20, 100]", "exponent = 20\nf0 = 0.1", 14, {"material.f0", "\"cook-torrance\""}},
      {"map = \"wall\"", "map = \"wal\"", 16, {"object.map", "\"wal\"", "\"wall\""}},
      {"material = \"paint\"",
       "material = \"gold\"",
       17,
       {"object.material", "\"gold\"", "not the name of a [[material]]"}},
      {"material = \"paint\"", "materials = [\"paint\", \"paint\"]", 17, {"has 2 materials", "no weights"}},
      {"width = 2.0", "width = 2.0\ntexels_per_metre = 3", 14, {"both", "texels_per_metre", "width"}},
      {"distance = [1, 20]", "distance = [20, 1]", 19, {"object.distance is [20, 1]", "smaller distance first"}},
      {"distance = [1, 20]", "distance = [0, 1]", 19, {"object.distance[0]", "0", "1e-6 to 1e9"}},
      {"direction = [0.3, 0.8, 0.5]", "direction = [0, 0, 0]", 21, {"light.direction", "0"}},
      {"direction = [0.3, 0.8, 0.5]", "direction = [0.3, 0.8]", 21, {"light.direction", "3 numbers"}},
      {"direction = [0.3, 0.8, 0.5]", "position = [0, 0, 1]\nirradiance = 3", 22, {"irradiance", "does not fit"}},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.to);
    std::vector<std::string> parts = c.parts;
    parts.insert(parts.begin(), path() + ":" + std::to_string(c.line) + ": ");
    expect_error(ErrorCode::kInput, parts, [&] { read(with(kScene, c.from, c.to)); });
  }
  expect_error(ErrorCode::kInput, {path(), "the scene", "no light"},
               [&] { read(kScene.substr(0, kScene.find("[[light]]"))); });
}

// Each texel has exactly one parent, up to the coarsest level, even if the sides are not powers of two.
TEST_F(SceneTest, TheSurveyIsWhatSumsSay) {
  for (const auto& [width, height] : {std::pair{64, 64}, std::pair{37, 75}, std::pair{1, 9}}) {
    SCOPED_TRACE(width);
    std::mt19937 random(7);
    std::normal_distribution<double> slope(0.0, 0.3);
    std::array<std::vector<float>, 3> planes;
    for (int i = 0; i < width * height; ++i) {
      const glm::dvec3 n = glm::normalize(glm::dvec3(2.0 * slope(random), slope(random), 1.0));
      for (std::size_t c = 0; c < 3; ++c) planes[c].push_back(static_cast<float>(n[static_cast<int>(c)]));
    }
    const PlaneStore normals(width, height, {planes[0].data(), planes[1].data(), planes[2].data()});
    const MapSurvey survey = survey_map(normals, {}, {});
    ASSERT_EQ(static_cast<int>(survey.levels.size()), mip_level_count(width, height) - 1);
    for (const LevelStatistics& level : survey.levels) {
      std::map<std::pair<int, int>, std::vector<glm::dvec3>> texels;
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          int column = x, row = y;
          for (int l = 1; l <= level.level; ++l) {
            column = column * mip_level_size(width, l) / mip_level_size(width, l - 1);
            row = row * mip_level_size(height, l) / mip_level_size(height, l - 1);
          }
          const auto i = static_cast<std::size_t>(y * width + x);
          texels[{row, column}].emplace_back(planes[0][i], planes[1][i], planes[2][i]);
        }
      double spread = 0.0, most = 0.0, difference = 0.0, variance = 0.0;
      for (const auto& [place, of] : texels) {
        const auto count = static_cast<double>(of.size());
        glm::dvec3 mean(0.0);
        for (const glm::dvec3& n : of) mean += n / count;
        double xx = 0.0, yy = 0.0, xy = 0.0;
        for (const glm::dvec3& n : of) {
          const glm::dvec3 off = n - mean;
          xx += off.x * off.x / count, yy += off.y * off.y / count, xy += off.x * off.y / count;
        }
        spread += 1.0 - glm::length(mean);
        most = std::max(most, 1.0 - glm::length(mean));
        difference += std::hypot(xx - yy, 2.0 * xy);
        variance += xx + yy;
      }
      EXPECT_EQ(level.texel_count, static_cast<double>(texels.size()));
      EXPECT_NEAR(level.spread_mean, spread / level.texel_count, 1e-6);
      EXPECT_NEAR(level.spread_max, most, 1e-6);
      EXPECT_NEAR(level.anisotropy, difference / variance, 1e-6);
    }
    SurveySettings many;
    many.threads = 3;
    const MapSurvey again = survey_map(normals, {}, many);
    for (std::size_t t = 0; t < survey.texels.size(); ++t) EXPECT_EQ(again.texels[t].normals, survey.texels[t].normals);
  }
}

// Tests the formula of the shader, whose error is at most 0.22 % compared with the exact mean over the sphere of
// lights.
TEST_F(SceneTest, LambertOfALobeIsTheShaders) {
  for (const double kappa : {0.5, 3.0, 20.0, 300.0})
    for (const double theta : {0.0, 0.5, 1.2, 1.6, 2.2}) {
      const double r = 1.0 / std::tanh(kappa) - 1.0 / kappa;
      const double exact = reference::convolved_lambert(kappa, theta);
      EXPECT_NEAR(lobe_lambert({0.0, 0.0, r}, {std::sin(theta), 0.0, std::cos(theta)}), exact, 0.006)
          << kappa << " " << theta;
    }
}

// On a map of two directions, one lobe has a large highlight error and two lobes are exact. Harmonics of low order and
// moments are not exact.
TEST_F(SceneTest, TwoDirectionsAreTwoLobes) {
  std::vector<float> x, y, z;
  for (int i = 0; i < 64 * 64; ++i) {
    const float side = (i % 64 + i / 64) % 2 == 0 ? 0.5f : -0.5f;
    x.push_back(side), y.push_back(0.0f), z.push_back(std::sqrt(0.75f));
  }
  const PlaneStore normals(64, 64, {x.data(), y.data(), z.data()});
  const MapSurvey survey = survey_map(normals, {}, {});
  EXPECT_NEAR(survey.levels[0].anisotropy, 1.0, 1e-6);
  LobeErrors errors(survey, {});
  const std::vector<ShadedBy> sharp = {{100.0}}, lambert = {ShadedBy{}};
  EXPECT_GT(errors.error(1, sharp, ColourModel::kNone), 0.5);
  EXPECT_LT(errors.error(2, sharp, ColourModel::kNone), 0.01);
  EXPECT_GT(errors.sh_error(4, sharp, ColourModel::kNone), 0.3);
  EXPECT_GT(errors.lean_error(sharp, ColourModel::kNone), 0.3);
  EXPECT_GT(errors.gmm_error(1, sharp, ColourModel::kNone), 0.5);
  EXPECT_LT(errors.gmm_error(2, sharp, ColourModel::kNone), 0.35)
      << "planar Gaussians round slanted facets and cut off tails";
  EXPECT_LT(errors.error(1, lambert, ColourModel::kNone), 0.05);
  EXPECT_LT(errors.error(2, lambert, ColourModel::kNone), 1e-3);
  // Harmonics of order 20 can represent a highlight with s = 8. The remaining error comes from the estimate, which
  // approximates Blinn-Phong by a vMF.
  EXPECT_LT(errors.sh_error(20, {{8.0}}, ColourModel::kNone), 0.15);
}

// If red facets are at x = +0.6 and blue facets at x = -0.6, lobes need their own colours. If both sides mix the
// colours equally, one colour is enough.
TEST_F(SceneTest, ColoursThatGoWithSlopesAreFound) {
  for (const bool correlated : {true, false}) {
    std::vector<float> x, y, z, r, g, b;
    for (int i = 0; i < 64 * 64; ++i) {
      const bool right = i % 2 == 0, red = correlated ? right : i / 64 % 2 == 0;
      x.push_back(right ? 0.6f : -0.6f), y.push_back(0.0f), z.push_back(0.8f);
      r.push_back(red ? 1.0f : 0.0f), g.push_back(0.0f), b.push_back(red ? 0.0f : 1.0f);
    }
    const PlaneStore normals(64, 64, {x.data(), y.data(), z.data()}), albedo(64, 64, {r.data(), g.data(), b.data()});
    const MapSurvey survey = survey_map(normals, {&albedo, nullptr}, {});
    EXPECT_EQ(survey.colour_range, 1.0);
    LobeErrors errors(survey, {2, 1});
    const double one = errors.error(2, {ShadedBy{}}, ColourModel::kMean);
    EXPECT_LT(errors.error(2, {ShadedBy{}}, ColourModel::kLobes), 0.01);
    if (correlated) {
      EXPECT_GT(errors.colour_correlation(2), 0.95);
      EXPECT_GT(one, 0.2);
    } else {
      EXPECT_LT(errors.colour_correlation(2), 0.05);
      EXPECT_LT(one, 0.05);
    }
  }
}

// One side has normals of weight 1, and the other side has normals of weight 0. Two lobes separate the weights; one
// lobe cannot.
TEST_F(SceneTest, WeightsThatGoWithSlopesAreFound) {
  std::vector<float> x, y, z, first, second;
  for (int i = 0; i < 64 * 64; ++i) {
    const bool right = i % 2 == 0;
    x.push_back(right ? 0.6f : -0.6f), y.push_back(0.0f), z.push_back(0.8f);
    first.push_back(right ? 1.0f : 0.0f), second.push_back(right ? 0.0f : 1.0f);
  }
  const PlaneStore normals(64, 64, {x.data(), y.data(), z.data()});
  WeightMap weights;
  weights.count = 2;
  weights.rgb_planes.emplace_back(64, 64, std::array<const float*, 3>{first.data(), second.data(), y.data()});
  const MapSurvey survey = survey_map(normals, {nullptr, &weights}, {});
  LobeErrors errors(survey, {});
  for (const int weight : {0, 1}) {
    EXPECT_GT(errors.error(1, {{100.0, weight}}, ColourModel::kNone), 0.5);
    EXPECT_LT(errors.error(2, {{100.0, weight}}, ColourModel::kNone), 0.01);
  }
}

// If all normals are equal, their only width is the roughness. One lobe with the corresponding length is exact, and
// diffuse light ignores the width.
TEST_F(SceneTest, RoughnessIsAWidthOfItsOwn) {
  const float length = 0.9f;
  const std::vector<float> none(64 * 64, 0.0f), z(64 * 64, length);
  const PlaneStore normals(64, 64, {none.data(), none.data(), z.data()});
  const MapSurvey survey = survey_map(normals, {}, {});
  LobeErrorSettings settings;
  settings.has_roughness = true;
  settings.mean_cosine = 0.9;
  LobeErrors errors(survey, settings);
  const ShadedBy own{std::numeric_limits<double>::infinity()};
  EXPECT_LT(errors.error(1, {own}, ColourModel::kNone), 1e-6);
  EXPECT_LT(errors.error(1, {ShadedBy{}}, ColourModel::kNone), 1e-3);
  LobeErrors plain(survey, {});
  EXPECT_GT(plain.error(1, {ShadedBy{}}, ColourModel::kNone), 0.02) << "the normal's length would darken diffuse light";
}

// Returns the error at texel centres of a bake with 4 lobes, over all levels from the first one on.
double measured_error(const PlaneStore& normals, double exponent) {
  static Device device = Device::open("");
  MapInputs inputs;
  inputs.normals = &normals;
  MovmfSettings settings;
  settings.lobe_count = 4;
  FitReport report;
  const MovmfMipmap mipmap = bake_movmf(device, inputs, settings, report, nullptr);
  AccuracySettings accuracy;
  accuracy.exponents = {exponent};
  accuracy.samples_per_level = 256;
  accuracy.first_level = 1;
  MovmfMeter meter(mipmap, false, accuracy);
  for (int l = 1; l < static_cast<int>(mipmap.levels.size()); ++l)
    meter.add_rows(l, 0, mipmap.levels[static_cast<std::size_t>(l)]);
  double sum = 0.0, count = 0.0;
  for (const AccuracyRow& row : meter.run(device, normals, nullptr, nullptr))
    if (row.brdf.kind == AccuracyBrdfKind::kBlinnPhong && row.point == AccuracyPoint::kCentre)
      sum += row.error, count += 1.0;
  return sum / count;
}

// On steep waves, highlights are too sharp for the sampled normals and directions, so the estimate uses the sharpest
// highlight that the samples resolve. The estimate is near the measured error of a bake. At s = 100, the estimate is
// 1.08 and the measured error is 1.00. At s = 500, they are 1.20 and 1.46. Shading each normal with its own sharpness
// gives 1.41 and more. More lobes give lower estimates.
TEST_F(SceneTest, SharpHighlightsOfSteepMapsHaveEstimatesToCompare) {
  std::vector<float> x, y, z;
  for (int i = 0; i < 128 * 128; ++i) {
    const int column = i % 128, row = i / 128;
    const glm::dvec3 n =
        glm::normalize(glm::dvec3(4.0 * std::sin(0.13 * column), 4.0 * std::cos(0.09 * row + 0.02 * column), 1.0));
    x.push_back(static_cast<float>(n.x)), y.push_back(static_cast<float>(n.y)), z.push_back(static_cast<float>(n.z));
  }
  const PlaneStore normals(128, 128, {x.data(), y.data(), z.data()});
  const MapSurvey survey = survey_map(normals, {}, {});
  LobeErrors errors(survey, {});
  for (const double s : {kEstimatedExponentMax, 5000.0, 1e5}) {
    const double lobes = errors.error(4, {{s}}, ColourModel::kNone);
    EXPECT_EQ(lobes, errors.error(4, {{kEstimatedExponentMax}}, ColourModel::kNone));
    EXPECT_NEAR(lobes, 1.3, 0.2);
    EXPECT_GT(errors.error(1, {{s}}, ColourModel::kNone), lobes);
    for (int count = 2; count <= 8; ++count)
      EXPECT_LT(errors.error(count, {{s}}, ColourModel::kNone),
                0.97 * errors.error(count - 1, {{s}}, ColourModel::kNone))
          << count << " lobes";
  }
  EXPECT_NEAR(errors.error(4, {{100.0}}, ColourModel::kNone) / measured_error(normals, 100.0), 1.0, 0.2);
  EXPECT_NEAR(errors.error(4, {{500.0}}, ColourModel::kNone) / measured_error(normals, 500.0), 0.9, 0.25);
}

TEST_F(SceneTest, LevelsAreThoseOfPixels) {
  SceneCamera camera{90.0, 100, 100};  // a pixel is 0.02 m at a distance of 1 m
  SceneObject object;
  object.texels_per_metre = 800.0;  // 16 texels
  object.distance_min = object.distance_max = 1.0;
  object.tilt_max = 0.0;
  EXPECT_EQ(seen_levels(camera, object, 1024, 11).first, 2)
      << "a corner's distance along the axis is 1 / sqrt(3): log2(16 / sqrt(3)) - 1/4";
  EXPECT_EQ(seen_levels(camera, object, 1024, 11).last, 4);
  object.distance_max = 8.0;
  object.tilt_max = 60.0;
  EXPECT_EQ(seen_levels(camera, object, 1024, 11).last, 7) << "taps are spread along the longer side: log2(128) - 1/4";
  object.distance_min = 1e-3;
  object.distance_max = 1e9;
  const SeenLevels all = seen_levels(camera, object, 1024, 11);
  EXPECT_EQ(all.first, 0);
  EXPECT_EQ(all.last, 10);
  object.texels_per_metre = 0.0;
  object.width = 1024.0 / 800.0;
  object.distance_min = 1.0;
  EXPECT_EQ(seen_levels(camera, object, 1024, 11).first, 2);
}

glm::dvec3 noise(int x, int y) {
  std::mt19937 random(static_cast<unsigned>(y * 4096 + x));
  std::uniform_real_distribution<double> slope(-0.4, 0.4);
  return {slope(random), slope(random), 1.0};
}

TEST_F(SceneTest, AFlatMapIsOneTexel) {
  write_map(32, [](int, int) { return glm::dvec3(0.0, 0.0, 1.0); });
  const MapPlan map = plan(kScene).maps[0];
  EXPECT_TRUE(map.is_constant);
  EXPECT_EQ(map.job.fitting.lobe_count, 1);
  EXPECT_EQ(map.job.fitting.first_level, 5);
  EXPECT_FALSE(effect(map.effects, "normals under texels").needed);
  EXPECT_FALSE(effect(map.effects, "several lobes, EM").needed);
  EXPECT_LT(map.chosen.cost.bytes, 0.01 * map.default_bake.cost.bytes);
}

TEST_F(SceneTest, SumsOfVmfsTakeLobes) {
  write_map(64, noise);
  const MapPlan map =
      plan(with(kScene, "brdf = \"blinn-phong\"\nexponent = [20, 100]\n", "brdf = \"ggx\"\nroughness = 0.4\n")).maps[0];
  for (const BakeCandidate& c : map.candidates) EXPECT_EQ(c.shape.representation, Representation::kMovmf) << c.name;
  expect_says(effect(map.effects, "moments of slopes (LEAN)").why, {"sum of vMFs", "vMF lobes"});
}

TEST_F(SceneTest, ASheenIsLitByLights) {
  const auto sheen = [](const std::string& roughness) {
    return with(kScene, "brdf = \"blinn-phong\"\nexponent = [20, 100]\n",
                "brdf = \"charlie\"\nroughness = " + roughness + "\n");
  };
  const std::string lit = "[environment]\nfile = \"wall.exr\"\n";
  const SceneMaterial material = read(sheen("[0.3, 0.6]")).materials[0];
  ASSERT_EQ(material.brdfs.size(), 2u);
  EXPECT_EQ(material.brdfs[0].kind, BrdfKind::kCharlie);
  EXPECT_EQ(material.brdfs[0].roughness, 0.3f);
  EXPECT_EQ(material.brdfs[1].specular, glm::vec3(1.0f));
  expect_error(ErrorCode::kInput, {path(), "environment", "\"paint\"", "charlie:0.3", "expected only lights"},
               [&] { read(sheen("[0.3, 0.6]") + lit); });
  expect_error(ErrorCode::kInput, {path(), "material.roughness", "0.04", "0.05 to 1"}, [&] { read(sheen("0.04")); });
  write_map(64, noise);
  const ScenePlan found = plan(sheen("0.1"));
  expect_says(effect(found.objects[0].effects, "highlight").why, {"s = 100"});
  for (const BakeCandidate& c : found.maps[0].candidates)
    EXPECT_EQ(c.shape.representation, Representation::kMovmf) << c.name;
}

TEST_F(SceneTest, DiffuseLightTakesOneLobe) {
  write_map(64, noise);
  const ScenePlan found = plan(with(kScene, "brdf = \"blinn-phong\"\nexponent = [20, 100]\n", "brdf = \"lambert\"\n"));
  const MapPlan& map = found.maps[0];
  EXPECT_EQ(map.job.fitting.lobe_count, 1);
  EXPECT_EQ(map.job.fitting.first_level, 0);
  EXPECT_TRUE(map.job.measured_exponents.empty());
  EXPECT_TRUE(effect(map.effects, "normals under texels").needed);
  EXPECT_FALSE(effect(map.effects, "measuring highlights").needed);
  EXPECT_FALSE(effect(found.objects[0].effects, "highlight").needed);
  EXPECT_FALSE(effect(found.objects[0].effects, "environment, diffuse").needed);
}

TEST_F(SceneTest, FarAwayTheFinestLevelsAreLeftOut) {
  write_map(64, noise);
  const MapPlan map = plan(with(kScene, "distance = [1, 20]", "distance = [120, 200]")).maps[0];
  EXPECT_GE(map.first_seen, 3);
  EXPECT_EQ(map.job.fitting.first_level, map.first_seen);
  EXPECT_FALSE(effect(map.effects, "finest levels").needed);
}

// Four directions and a sharp highlight need as many lobes as the default settings have, so the plan keeps these
// settings.
TEST_F(SceneTest, WhereAllIsNeededThePlanIsTheDefault) {
  write_map(64, [](int x, int y) { return glm::dvec3(x % 2 == 0 ? 0.5 : -0.5, y % 2 == 0 ? 0.5 : -0.5, 1.0); });
  const MapPlan map = plan(kScene).maps[0];
  EXPECT_EQ(map.job.fitting.lobe_count, 4);
  EXPECT_EQ(map.chosen.name, map.default_bake.name);
  EXPECT_EQ(map.stated_difference, 0.0);
  EXPECT_TRUE(effect(map.effects, "several lobes, EM").needed);
  EXPECT_TRUE(effect(map.effects, "aligned lobes").needed);
}

TEST_F(SceneTest, BudgetsAndTargetsAreKeptOrRefused) {
  write_map(64, [](int x, int y) { return glm::dvec3(x % 2 == 0 ? 0.5 : -0.5, y % 2 == 0 ? 0.5 : -0.5, 1.0); });
  const MapPlan map = plan(with(kScene, "estimate_margin = 0.05", "bytes = 50000")).maps[0];
  EXPECT_LE(map.chosen.cost.bytes, 50000.0);
  EXPECT_LT(map.job.fitting.lobe_count, 4);
  expect_error(ErrorCode::kVerification, {"no settings", "bake_ms", "1"},
               [&] { plan(with(kScene, "estimate_margin = 0.05", "bake_ms = 1")); });
  expect_error(ErrorCode::kVerification, {"no settings", "bytes", "100"},
               [&] { plan(with(kScene, "estimate_margin = 0.05", "bytes = 100")); });
  write_map(64, noise);
  expect_error(ErrorCode::kVerification, {"wall.exr", "target_error 0.0001"},
               [&] { plan(with(kScene, "estimate_margin = 0.05", "target_error = 0.0001")); });
}

// With a target, the trials of the bake decide, so a plan must not promise a number of lobes or bytes.
TEST_F(SceneTest, WhatTrialsChooseIsARange) {
  write_map(64, [](int x, int y) { return glm::dvec3(x % 2 == 0 ? 0.5 : -0.5, y % 2 == 0 ? 0.5 : -0.5, 1.0); });
  for (const char* target : {"0.2", "0.5", "1.9"}) {
    SCOPED_TRACE(target);
    const SceneDescription scene =
        read(with(kScene, "estimate_margin = 0.05", fmt::format("target_error = {}", target)));
    const ScenePlan found = plan_scene(scene, {1}, nullptr);
    const MapPlan& map = found.maps[0];
    const nlohmann::json json = plan_json(scene, found, {"."});
    const std::string text = plan_text(scene, found, 200);
    ASSERT_EQ(map.trials.has_value(), map.chosen.shape.lobe_count > 1);
    EXPECT_EQ(json["maps"][0].contains("trials"), map.trials.has_value());
    EXPECT_EQ(text.find("trials") != std::string::npos, map.trials.has_value()) << text;
    if (!map.trials) {
      EXPECT_EQ(found.cost_min.bytes, found.cost.bytes);
      EXPECT_EQ(found.cost_max.bytes, found.cost.bytes);
      continue;
    }
    EXPECT_EQ(json["maps"][0]["trials"]["lobes"], (std::vector<int>{lobe_counts().fewest, lobe_counts().most}));
    EXPECT_EQ(map.trials->most.cost.bytes, 8.0 * map.trials->fewest.cost.bytes);
    EXPECT_EQ(json["bytes_range"], (std::vector<double>{found.cost_min.bytes, found.cost_max.bytes}));
    EXPECT_LT(found.cost_min.bytes, found.cost.bytes);
    EXPECT_GT(found.cost_max.bytes, found.cost.bytes);
    expect_says(text.substr(0, text.find('\n')), {"vmf, 1 to 8 lobes (trials choose the number)"});
    // The stated time excludes trials. Both the plan of a map and the total state how many trials there may be and how
    // long they take.
    const std::string in_all = text.substr(text.rfind("in total: "));
    for (const std::string& part : {text, in_all})
      expect_says(part, {"plus the trials (up to 24 per map, which take a few seconds in total)"});
    EXPECT_GE(map.stated_difference, std::stod(target))
        << "the chosen settings need not have a lower error than the target";
  }
}

// The estimates for one, two and three lobes are listed in this order, whatever their textures cost. Other text is
// separate.
TEST_F(SceneTest, WhatWasTriedIsAListInOrder) {
  write_map(64, [](int x, int y) { return glm::dvec3(x % 2 == 0 ? 0.5 : -0.5, y % 2 == 0 ? 0.5 : -0.5, 1.0); });
  write_bytes(folder_ / "albedo.exr", read_bytes(folder_ / "wall.exr"));
  const std::string coloured = with(kScene, "normal = \"wall.exr\"", "normal = \"wall.exr\"\nalbedo = \"albedo.exr\"");
  for (const std::string& scene_text : {std::string(kScene), coloured}) {
    const SceneDescription scene = read(scene_text);
    const ScenePlan found = plan_scene(scene, {1}, nullptr);
    const PlannedEffect& lobes = effect(found.maps[0].effects, "several lobes, EM");
    ASSERT_EQ(lobes.list.size(), 4u);
    for (std::size_t i = 0; i < lobes.list.size(); ++i) {
      EXPECT_EQ(lobes.list[i].name, fmt::format("{} lobe{}", i + 1, i == 0 ? "" : "s"));
      EXPECT_EQ(lobes.list[i].value.find("one colour") != std::string::npos, scene_text == coloured && i > 0);
      EXPECT_EQ(lobes.why.find(lobes.list[i].name + ": "), std::string::npos) << lobes.why;
    }
    EXPECT_FALSE(effect(found.maps[0].effects, "planar Gaussians").list.empty());
    // A line break never splits an item.
    const std::string text = plan_text(scene, found, 120);
    for (const PlannedItem& item : lobes.list)
      EXPECT_NE(text.find(item.name + (item.name == "1 lobe" ? ":  " : ": ") + item.value), std::string::npos) << text;
  }
}

TEST_F(SceneTest, TheTableKeepsToItsWidth) {
  write_map(64, noise);
  const SceneDescription scene = read(kScene);
  const ScenePlan found = plan_scene(scene, {1}, nullptr);
  for (const int width : {80, 120}) {
    std::istringstream lines(plan_text(scene, found, width));
    for (std::string line; std::getline(lines, line);) {
      EXPECT_LE(line.size(), static_cast<std::size_t>(width)) << line;
      EXPECT_FALSE(line.ends_with(' ')) << line;
    }
  }
}

}  // namespace
}  // namespace multum::testing
