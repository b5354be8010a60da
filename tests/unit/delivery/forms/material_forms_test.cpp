// SPDX-License-Identifier: Apache-2.0
// Tests the forms of a material on a sphere. Steep bumps need fitted forms, a smooth map does not, and no form has a
// higher error than the plain form.
#include "host/delivery/forms/material_forms.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <glm/geometric.hpp>

#include "host/delivery/export/uastc/level_texture.h"
#include "host/delivery/forms/simple_views.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using ::testing::Test;

constexpr int kSide = 256;

std::uint8_t code_of_share(double share) { return static_cast<std::uint8_t>(std::lround(255.0 * share)); }

// Fills all levels with the results of `level_texel(level, x, y)`, which returns four values from 0 to 1.
void fill(LevelFile& file, const std::function<glm::dvec4(int, int, int)>& level_texel) {
  for (int level = 0; level < file.level_count(); ++level) {
    const int width = mip_level_size(file.width(), level), height = mip_level_size(file.height(), level);
    std::vector<std::uint8_t> codes;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const glm::dvec4 texel = level_texel(level, x, y);
        for (int c = 0; c < 4; ++c) codes.push_back(code_of_share(texel[c]));
      }
    file.write_rows(level, 0, codes);
  }
}

// Slopes alternate between +steepness and -steepness from texel to texel, so their mean is flat. The fitted roughness
// follows from their variance.
class MaterialFormsTest : public Test {
 protected:
  MaterialFormsTest()
      : averages_(folder_.path(), "averages", kSide, kSide),
        normals_(folder_.path(), "normals", kSide, kSide),
        surface_(folder_.path(), "surface", kSide, kSide) {}

  void set_bumps(double steepness, double roughness, double fitted_roughness) {
    const auto normal = [&](int level, int x, int y) {
      const double sign = level > 0 ? 0.0 : 1.0;
      const glm::dvec3 n = glm::normalize(
          glm::dvec3((x + y) % 2 == 0 ? steepness : -steepness, y % 2 == 0 ? steepness : -steepness, 1.0));
      return glm::dvec3(sign * n.x, sign * n.y, n.z);
    };
    fill(averages_, [&](int level, int x, int y) { return glm::dvec4(0.5 + 0.5 * normal(level, x, y), roughness); });
    fill(normals_,
         [&](int level, int x, int y) { return glm::dvec4(0.5 + 0.5 * glm::normalize(normal(level, x, y)), 1.0); });
    fill(surface_,
         [&](int level, int, int) { return glm::dvec4(1.0, level == 0 ? roughness : fitted_roughness, 1.0, 1.0); });
  }
  static std::vector<ModelPicture> pictures() {
    static const TriangleMesh mesh = textured_sphere();
    static const ModelPictures drawn(mesh, PictureSet::of_all_sizes(1.0), 2, nullptr);
    return drawn.of({{0}, [](const glm::dvec2& uv) { return glm::dvec2(uv.x, 1.0 - uv.y); }}, 60);
  }
  // Calls `body` with a meter of the current material.
  template <typename Body>
  void measure(const Body& body, Engine engine = Engine::kThree, const std::vector<ModelPicture>& seen = pictures(),
               FormSurroundings surroundings = FormSurroundings::kRoom) const {
    const TextureFrame frame{kSide, kSide, averages_.level_count()};
    const LevelFileTexture averages(averages_, frame, 1 << 24), normals(normals_, frame, 1 << 24),
        surface(surface_, frame, 1 << 24);
    body(FormMeter({&averages, &normals, &surface, 1.0, 0.8}, seen, {engine, true, 2, surroundings}));
  }

  testing::TemporaryFolder folder_;
  LevelFile averages_, normals_, surface_;
};

TEST_F(MaterialFormsTest, APixelIsWhereTheRayMeetsTheSphere) {
  const std::vector<ModelPicture> seen = pictures();
  ASSERT_GE(seen.size(), 12u);
  for (const ModelPicture& picture : seen)
    for (const ModelPixel& pixel : picture.pixels) {
      // The point is on the plane of a nearby triangle, which differs a little from the sphere at the silhouette.
      EXPECT_NEAR(glm::length(pixel.middle.position), 1.0, 0.02);
      EXPECT_GT(glm::dot(pixel.middle.position, pixel.middle.normal), 0.998);
      EXPECT_GT(glm::dot(pixel.middle.normal, picture.eye - pixel.middle.position), 0.0);
      EXPECT_GE(pixel.samples.size(), 32u);
      EXPECT_LE(pixel.samples.size(), 64u);
      glm::dvec3 mean(0.0);
      for (const SurfacePoint& sample : pixel.samples)
        mean += sample.position / static_cast<double>(pixel.samples.size());
      const double step = glm::length(pixel.along_x.position) + glm::length(pixel.along_y.position);
      EXPECT_LT(glm::length(mean - pixel.middle.position), step);
    }
}

TEST_F(MaterialFormsTest, SteepBumpsAskForFittedRoughness) {
  set_bumps(0.6, 0.2, 0.75);
  measure([](const FormMeter& meter) {
    const ChosenNormalForm chosen = choose_normal_form(meter, NormalForm::of(meter.level_count(), {}));
    EXPECT_FALSE(chosen.form.is_plain());
    EXPECT_LT(chosen.chosen.mean, 0.95 * chosen.plain.mean);
    EXPECT_TRUE(chosen.form.levels[0].is_plain());
    for (std::size_t d = 0; d < meter.views().size(); ++d)
      EXPECT_LE(chosen.chosen.by_view[d], chosen.plain.by_view[d] + kFormTolerance + 1e-9);
  });
}

TEST_F(MaterialFormsTest, ASmoothMapStaysAsItIs) {
  set_bumps(0.0, 0.4, 0.4);
  measure([](const FormMeter& meter) {
    const ChosenNormalForm chosen = choose_normal_form(meter, NormalForm::of(meter.level_count(), {}));
    EXPECT_TRUE(chosen.form.is_plain());
    EXPECT_EQ(chosen.plain.mean, chosen.chosen.mean);
  });
}

TEST_F(MaterialFormsTest, AFitThatIsWrongIsNotTaken) {
  set_bumps(0.0, 0.3, 1.0);
  measure([](const FormMeter& meter) {
    const ChosenNormalForm chosen = choose_normal_form(meter, NormalForm::of(meter.level_count(), {}));
    EXPECT_GT(chosen.fitted.mean, chosen.plain.mean + 10.0);
    EXPECT_LE(chosen.chosen.mean, chosen.plain.mean);
  });
}

TEST_F(MaterialFormsTest, AFitThatIsKeptIsWorseInNoView) {
  set_bumps(0.25, 0.3, 1.0);  // roughness that is higher than the bumps require
  measure([](const FormMeter& meter) {
    const ChosenNormalForm chosen = choose_normal_form(meter, NormalForm::of(meter.level_count(), {true, 1.0}));
    EXPECT_LT(chosen.chosen.mean, 0.95 * chosen.fitted.mean);
    for (std::size_t v = 0; v < meter.views().size(); ++v)
      EXPECT_LE(chosen.chosen.by_view[v], chosen.fitted.by_view[v] + kFormTolerance + 1e-9);
  });
}

TEST_F(MaterialFormsTest, LevelsBeyondThePicturesAreAsTheLastThatIsSeen) {
  set_bumps(0.6, 0.2, 0.75);
  measure(
      [](const FormMeter& meter) {
        NormalForm form = NormalForm::of(meter.level_count(), {});
        meter.improve(form, std::vector<double>(meter.views().size(), 1e9));
        ASSERT_EQ(form.levels.size(), 9u);
        EXPECT_GT(form.levels[5].fitted_share, 0.0);
        for (std::size_t level = 6; level < 9; ++level) EXPECT_EQ(form.levels[level], form.levels[5]);
      },
      Engine::kUnity, simple_views(kSide, kSide, 40));  // up to 16 texels per pixel, plus half an octave
}

TEST_F(MaterialFormsTest, PicturesAreThoseOfTheEngine) {
  set_bumps(0.0, 0.3, 0.3);
  const auto error_for = [&](Engine engine) {
    double error = 0.0;
    measure([&](const FormMeter& meter) { error = meter.normals(NormalForm::of(meter.level_count(), {})).mean; },
            engine);
    return error;
  };
  // On a flat map only the sphere's curvature is filtered, and three.js widens highlights most.
  EXPECT_GT(error_for(Engine::kThree), 1.5 * error_for(Engine::kFilament));
  EXPECT_NE(error_for(Engine::kUnity), error_for(Engine::kFilament));
  // In Godot, the normals include the normal map.
  set_bumps(0.6, 0.3, 0.3);
  EXPECT_NE(error_for(Engine::kGodot), error_for(Engine::kUnity));
}

TEST_F(MaterialFormsTest, MorePointsAreNearer) {
  set_bumps(0.0, 0.3, 0.3);
  measure([](const FormMeter& meter) {
    const NormalForm plain = NormalForm::of(meter.level_count(), {});
    EXPECT_LT(meter.points(plain).mean, meter.normals(plain).mean);
    EXPECT_LT(meter.points(plain).mean, 5.0);
  });
}

// Glints of this roughness are small and bright. Without the choice of lights, the two errors differ by a third.
TEST_F(MaterialFormsTest, UnderASkyAFewPixelsAreLikeMany) {
  set_bumps(0.5, 0.1, 0.1);
  const auto errors = [&](std::size_t pixels) {
    LitErrors found;
    measure([&](const FormMeter& meter) { found = meter.lit_normals(NormalForm::of(meter.level_count(), {})); },
            Engine::kThree, shape_views(kSide, kSide, {{{8.0, 8.0}}, {kSphere}, 24000.0, 0.0, pixels, 8}),
            FormSurroundings::kSky);
    return found;
  };
  const LitErrors few = errors(1000), many = errors(12000);
  for (FormError LitErrors::*light : {&LitErrors::suns, &LitErrors::surroundings}) {
    EXPECT_GT((many.*light).mean, 5.0);
    EXPECT_NEAR((few.*light).mean, (many.*light).mean, 0.1 * (many.*light).mean);
  }
}

TEST_F(MaterialFormsTest, UnderASkyAFlatMapHasNoError) {
  set_bumps(0.0, 0.3, 0.3);
  measure(
      [](const FormMeter& meter) {
        const LitErrors plain = meter.lit_normals(NormalForm::of(meter.level_count(), {}));
        EXPECT_LT(plain.suns.mean, 0.2);
        EXPECT_LT(plain.surroundings.mean, 0.2);
      },
      Engine::kThree, shape_views(kSide, kSide, {{{8.0, 8.0}}, {kSphere}, 24000.0, 0.0, 200, 8}),
      FormSurroundings::kSky);
}

TEST(PixelTapsTest, LevelsAndTapsAreASamplers) {
  const TextureFrame frame{256, 128, 9};
  const auto taps_of = [&](double x, double y) {
    return PixelTaps::of({0.5, 0.5}, {x / 256.0, 0.0}, {0.0, y / 128.0}, frame, 16, 0.0);
  };
  const PixelTaps square = taps_of(4.0, 4.0);
  EXPECT_EQ(square.places.size(), 1u);
  EXPECT_EQ(square.levels[0], 2);
  EXPECT_DOUBLE_EQ(square.coarser_share, 0.0);
  const PixelTaps long_one = taps_of(24.0, 2.0);
  EXPECT_EQ(long_one.places.size(), 12u);
  EXPECT_EQ(long_one.levels[0], 1);
  EXPECT_NEAR(long_one.places.front().x, 0.5 - 11.0 / 256.0, 1e-12);
  const PixelTaps longest = taps_of(64.0, 1.0);
  EXPECT_EQ(longest.places.size(), 16u);
  EXPECT_EQ(longest.levels[0], 2);
}

TEST(PixelTapsTest, TexelsWrap) {
  EXPECT_EQ(wrapped_texel(-1, 8, WrapMode::kPeriodic), 7);
  EXPECT_EQ(wrapped_texel(-1, 8, WrapMode::kMirror), 0);
  EXPECT_EQ(wrapped_texel(9, 8, WrapMode::kMirror), 6);
  EXPECT_EQ(wrapped_texel(9, 8, WrapMode::kClamp), 7);
}

}  // namespace
}  // namespace multum
