// SPDX-License-Identifier: Apache-2.0
// Tests pyramids in the runtime. Compares our choice of level with the driver's choice and with double precision.
// Compares highlights drawn with and without the pyramid. Also tests surfaces at a level of detail, the materials of a
// model, and the modes of multum-view for pyramids.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include <glm/geometric.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "host/formats/asset/pyramid/pyramid_sample.h"
#include "host/formats/asset/pyramid/pyramid_surface.h"
#include "host/formats/asset/pyramid/reflectance_mapping.h"
#include "host/foundation/base/processes/child_process.h"
#include "host/lab/reference/reflectance.h"
#include "runtime_gl/context/headless_context.h"
#include "runtime_gl/pyramid/pyramid_renderer.h"
#include "runtime_gl/render/picture_error.h"
#include "tests/gl/test_context.h"
#include "tests/gl/test_maps.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::TemporaryFolder;

/// Makes a pyramid with a box filter. The sides are powers of two, and `value(x, y, channel)` returns the values of
/// level 0.
template <typename Value>
Pyramid make_pyramid(PyramidKind kind, int size, WrapMode wrap, const Value& value) {
  Pyramid pyramid;
  pyramid.header.kind = kind;
  BakedHeader& map = pyramid.header.map;
  map.encoding = StorageEncoding::kFloat;
  map.wrap_s = map.wrap_t = wrap;
  map.width = map.height = size;
  const int channels = pyramid.header.channel_count();
  for (int l = 0; l < pyramid.header.level_count(); ++l) {
    PyramidLevel level{size >> l, size >> l, {}};
    for (int y = 0; y < level.height; ++y)
      for (int x = 0; x < level.width; ++x)
        for (int c = 0; c < channels; ++c) {
          float sum = 0.0f;
          if (l == 0) {
            sum = static_cast<float>(value(x, y, c));
          } else {
            const std::vector<float>& finer = pyramid.levels.back().values;
            for (int k = 0; k < 4; ++k)
              sum +=
                  0.25f *
                  finer[static_cast<std::size_t>(((2 * y + k / 2) * 2 * level.width + 2 * x + k % 2) * channels + c)];
          }
          level.values.push_back(sum);
        }
    pyramid.levels.push_back(std::move(level));
  }
  return pyramid;
}

gl::MeshData plane() {
  gl::MeshData data;
  for (int i = 0; i < 4; ++i) {
    const float x = i % 2 == 0 ? -30.0f : 30.0f, y = i < 2 ? 0.0f : 60.0f;
    data.vertices.push_back(
        {{x, y, 0.0f}, {0.0f, 0.0f, 1.0f}, {1.0f, 0.0f, 0.0f, 1.0f}, {x / 60.0f + 0.5f, y / 60.0f}});
  }
  data.indices = {0, 1, 3, 0, 3, 2};
  return data;
}

/// Makes a ball of radius 0.9 with exact normals.
gl::MeshData ball(int steps) {
  gl::MeshData data;
  for (int j = 0; j <= steps; ++j)
    for (int i = 0; i <= 2 * steps; ++i) {
      const double theta = M_PI * j / steps, phi = M_PI * i / steps;
      const glm::vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
      data.vertices.push_back({0.9f * n, n, {1.0f, 0.0f, 0.0f, 1.0f}, {}});
    }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(j * (2 * steps + 1) + i); };
  for (int j = 0; j < steps; ++j)
    for (int i = 0; i < 2 * steps; ++i)
      for (const std::uint32_t k : {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)})
        data.indices.push_back(k);
  return data;
}

class PyramidViewTest : public ::testing::Test {
 protected:
  const gl::GlFunctions& gl() const { return context_->functions(); }
  std::unique_ptr<gl::HeadlessContext> context_ = gl::make_test_context(gl::test_backend());
};

// Computes where the ray through (x, y) of the picture meets the plane, in texels, in closed form.
glm::dvec2 texels_at(const gl::PyramidScene& scene, double x, double y, int width, int height, int size) {
  const glm::dmat4 inverse = glm::inverse(glm::dmat4(gl::view_projection(scene.camera, width, height, {0.0f, 0.0f})));
  const auto point = [&](double depth) {
    const glm::dvec4 p = inverse * glm::dvec4(2.0 * x / width - 1.0, 2.0 * y / height - 1.0, depth, 1.0);
    return glm::dvec3(p) / p.w;
  };
  const glm::dvec3 near = point(-1.0), far = point(1.0);
  const glm::dvec3 hit = near + (far - near) * (near.z / (near.z - far.z));
  return glm::dvec2(hit.x / 60.0 + 0.5, 1.0 - hit.y / 60.0) * (static_cast<double>(scene.uv_scale) * size);
}

// The GL uses differences between the fragments of a quad instead of derivatives. On a plane in perspective, this
// changes the level by a few hundredths. Mesa follows the same rule with its own log2. The two levels differ by at most
// 0.1.
TEST_F(PyramidViewTest, TheLevelIsWilliamsAndTheDriversIsNear) {
  constexpr int kSize = 64, kWidth = 128, kHeight = 96;
  const Pyramid pyramid =
      make_pyramid(PyramidKind::kColour, kSize, WrapMode::kPeriodic, [](int, int, int) { return 1.0; });
  const gl::Texture texture = gl::make_pyramid_texture(gl(), pyramid, gl::PyramidLookup::kLevel, 1.0f);
  const gl::Mesh mesh(gl(), plane());
  gl::PyramidScene scene;
  scene.uv_scale = 60.0f;
  gl::PyramidRenderer renderer(gl(), kWidth, kHeight);
  const gl::FloatImage levels = renderer.draw_levels(mesh, texture, false, scene);
  double worst_ours = 0.0, worst_driver = 0.0;
  int counted = 0;
  for (int row = 0; row < kHeight; ++row)
    for (int column = 0; column < kWidth; ++column) {
      const float* const pixel = &levels.rgba[static_cast<std::size_t>(4 * (row * kWidth + column))];
      if (pixel[3] == 0.0f) continue;
      // This is the middle of the quad of fragments whose differences are used.
      const double x = column / 2 * 2 + 1, y = (kHeight - 1 - row) / 2 * 2 + 1;
      const auto at = [&](double dx, double dy) { return texels_at(scene, x + dx, y + dy, kWidth, kHeight, kSize); };
      const glm::dvec2 along_x = at(0.5, 0.0) - at(-0.5, 0.0), along_y = at(0.0, 0.5) - at(0.0, -0.5);
      const double expected = mip_level_of({along_x.x, along_x.y, along_y.x, along_y.y});
      worst_ours = std::max(worst_ours, std::abs(static_cast<double>(pixel[0]) - expected));
      worst_driver = std::max(worst_driver, std::abs(static_cast<double>(pixel[1]) - static_cast<double>(pixel[0])));
      ++counted;
    }
  EXPECT_GT(counted, kWidth * kHeight / 2);
  EXPECT_LT(worst_ours, 0.05);
  EXPECT_LT(worst_driver, 0.1);
  RecordProperty("ours_against_double", std::to_string(worst_ours));
  RecordProperty("driver_against_ours", std::to_string(worst_driver));
  std::printf("largest differences in levels: ours and double %.4f, the driver and ours %.4f\n", worst_ours,
              worst_driver);
}

// textureLod at our level equals the trilinear filter of the reference, also across both kinds of borders.
TEST_F(PyramidViewTest, SamplesAreTheReferences) {
  constexpr int kSize = 16, kWidth = 64, kHeight = 48;
  for (const WrapMode wrap : {WrapMode::kPeriodic, WrapMode::kClamp}) {
    const Pyramid pyramid = make_pyramid(PyramidKind::kColour, kSize, wrap,
                                         [](int x, int y, int c) { return ((x * 7 + y * 13 + c * 5) % 16) / 15.0; });
    const gl::Texture texture = gl::make_pyramid_texture(gl(), pyramid, gl::PyramidLookup::kLevel, 1.0f);
    const gl::Mesh mesh(gl(), plane());
    gl::PyramidScene scene;
    scene.uv_scale = 20.0f;
    gl::PyramidRenderer renderer(gl(), kWidth, kHeight);
    const gl::FloatImage levels = renderer.draw_levels(mesh, texture, false, scene);
    const gl::FloatImage picture = renderer.draw(mesh, texture, gl::PyramidLookup::kLevel, false, scene);
    double worst = 0.0;
    for (int row = 0; row < kHeight; ++row)
      for (int column = 0; column < kWidth; ++column) {
        const auto first = static_cast<std::size_t>(4 * (row * kWidth + column));
        if (levels.rgba[first + 3] == 0.0f) continue;
        const glm::dvec2 texel = texels_at(scene, column + 0.5, kHeight - row - 0.5, kWidth, kHeight, kSize);
        // st = (u, 1 - v) * repeats, because v increases upwards on the plane.
        const double s = texel.x / kSize, t = texel.y / kSize;
        const PyramidSample expected = sample_pyramid(pyramid, s, t, static_cast<double>(levels.rgba[first]));
        for (std::size_t c = 0; c < 3; ++c)
          worst = std::max(worst, std::abs(static_cast<double>(picture.rgba[first + c]) - expected[c]));
      }
    EXPECT_LT(worst, 0.02) << wrap_mode_name(wrap);
  }
}

std::vector<gl::Light> nine_lights_less_one() {
  std::vector<gl::Light> lights;
  for (int i = 0; i < 8; ++i)
    lights.push_back({{std::cos(0.8f * static_cast<float>(i)), std::sin(0.8f * static_cast<float>(i)),
                       0.3f + 0.2f * static_cast<float>(i)},
                      glm::vec3(0.5f + 0.3f * static_cast<float>(i))});
  return lights;
}

// Makes a map of the lights with the reference in double precision, which uses 2 x 2 normals per texel.
Pyramid reflectance_of(const gl::PhongLights& lights, int size) {
  const ReflectanceFrame frame;
  std::vector<reference::DistantLight> distant;
  for (const gl::Light& light : lights.lights)
    distant.push_back({glm::normalize(glm::dvec3(light.direction)), glm::dvec3(light.irradiance)});
  const reference::PhongSurface surface = {static_cast<double>(lights.exponent), glm::dvec3(lights.diffuse),
                                           glm::dvec3(lights.specular)};
  std::vector<glm::dvec3> texels;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      texels.push_back(reference::phong_radiance(reflectance_normal(frame, {(x + 0.5) / size, (y + 0.5) / size}),
                                                 frame.viewer, distant, surface));
  return make_pyramid(PyramidKind::kReflectance, size, WrapMode::kClamp,
                      [&](int x, int y, int c) { return texels[static_cast<std::size_t>(y * size + x)][c]; });
}

class HighlightTest : public PyramidViewTest {
 protected:
  HighlightTest() {
    lights.lights = nine_lights_less_one();
    lights.exponent = 300.0f;
    scene.camera.eye = {0.0f, 0.0f, 60.0f};
    scene.camera.target = {0.0f, 0.0f, 0.0f};
    scene.camera.up = {0.0f, 1.0f, 0.0f};
    scene.camera.fov_y_degrees = 2.0f;
    scene.camera.near_distance = 50.0f;
    scene.level_bias = gl::kEqualVarianceBias;
  }
  gl::PhongLights lights;
  gl::PyramidScene scene;
};

// On a large ball, every lookup gives the same light as shading in the fragment shader, within the resolution of the
// map.
TEST_F(HighlightTest, AMapShowsWhatItsLightsDo) {
  const Pyramid map = reflectance_of(lights, 256);
  const gl::Mesh mesh(gl(), ball(48));
  gl::PyramidRenderer renderer(gl(), 192, 192);
  const gl::FloatImage shaded = renderer.draw_phong(mesh, lights, scene);
  for (const gl::PyramidLookup lookup : {gl::PyramidLookup::kBilinear, gl::PyramidLookup::kLevel}) {
    const gl::Texture texture = gl::make_pyramid_texture(gl(), map, lookup, 1.0f);
    EXPECT_LT(gl::picture_error(renderer.draw(mesh, texture, lookup, true, scene), shaded).relative_l1, 0.05);
  }
}

// On a ball of 16 pixels, normals turn by some degrees per pixel. This test measures the effect that Williams shows in
// figures 18 and 19.
TEST_F(HighlightTest, ThePyramidAntialiases) {
  const Pyramid map = reflectance_of(lights, 256);
  const gl::Mesh mesh(gl(), ball(48));
  gl::PyramidRenderer renderer(gl(), 16, 16);
  const gl::Texture nearest = gl::make_pyramid_texture(gl(), map, gl::PyramidLookup::kBilinear, 1.0f);
  std::vector<gl::FloatImage> references, before, after;
  for (int k = 0; k < 6; ++k) {
    const glm::vec2 shift(static_cast<float>(k) / 6.0f - 0.5f, 0.1f * static_cast<float>(k));
    references.push_back(gl::supersampled(8, [&](glm::vec2 offset) {
      scene.shift = shift + offset;
      return renderer.draw_phong(mesh, lights, scene);
    }));
    scene.shift = shift;
    before.push_back(renderer.draw(mesh, nearest, gl::PyramidLookup::kBilinear, true, scene));
    after.push_back(renderer.draw(mesh, nearest, gl::PyramidLookup::kLevel, true, scene));
  }
  // Maps do not antialias silhouettes, so only pixels that the ball covers completely are compared.
  for (std::size_t k = 0; k < references.size(); ++k)
    for (std::size_t i = 0; i < references[k].rgba.size(); i += 4)
      if (references[k].rgba[i + 3] < 1.0f)
        for (std::size_t c = 0; c < 3; ++c)
          references[k].rgba[i + c] = before[k].rgba[i + c] = after[k].rgba[i + c] = 0.0f;
  const double error_before = gl::picture_error(before[0], references[0]).relative_l1;
  const double error_after = gl::picture_error(after[0], references[0]).relative_l1;
  const double flicker_before = gl::flicker(before, references), flicker_after = gl::flicker(after, references);
  std::printf("error %.3f -> %.3f, flicker %.3f -> %.3f\n", error_before, error_after, flicker_before, flicker_after);
  EXPECT_LT(error_after, 0.8 * error_before);
  EXPECT_LT(flicker_after, 0.7 * flicker_before);
}

TEST(PyramidSurfaceTest, LevelsAreSmootherAndFewer) {
  const Pyramid heights = make_pyramid(PyramidKind::kHeight, 32, WrapMode::kClamp,
                                       [](int x, int y, int) { return 0.1 * std::sin(0.7 * x) * std::cos(0.9 * y); });
  double last = 1e9;
  for (const double level : {0.0, 0.5, 1.0, 2.5, 4.0}) {
    const PyramidSurface surface = surface_at_level(heights, level);
    EXPECT_EQ(surface.columns, std::max(2, static_cast<int>(std::lround(32.0 * std::exp2(-level)))));
    EXPECT_EQ(surface.indices.size(), static_cast<std::size_t>(6 * (surface.columns - 1) * (surface.rows - 1)));
    double square = 0.0;
    for (const glm::vec3& p : surface.positions) square += static_cast<double>(p.z * p.z);
    square /= static_cast<double>(surface.positions.size());
    EXPECT_LT(square, last) << level;
    last = square;
    for (const glm::vec3& n : surface.normals) EXPECT_GT(n.z, 0.0f);
    EXPECT_EQ(surface.positions.front().x, -0.5f);
    EXPECT_EQ(surface.positions.back().y, -0.5f);
    EXPECT_EQ(surface.uvs.front(), glm::vec2(0.0f, 1.0f));
  }
  // With a slope of 1 in x, the normal leans by 45 degrees at every level, away from the border.
  const Pyramid ramp =
      make_pyramid(PyramidKind::kHeight, 32, WrapMode::kClamp, [](int x, int, int) { return (x + 0.5) / 32.0; });
  const PyramidSurface surface = surface_at_level(ramp, 1.0);
  const glm::vec3 n = surface.normals[static_cast<std::size_t>(8 * surface.columns + 8)];
  EXPECT_NEAR(n.x, -std::sqrt(0.5f), 1e-3f);
  EXPECT_NEAR(n.z, std::sqrt(0.5f), 1e-3f);
}

// Draws a surface of height 0, which is seen face-on from one unit above through a lens that maps one unit to 64
// pixels. The finest points of the surface are 64 / 63 pixels apart, because there are 64 points and 63 gaps per side.
TEST(PyramidSurfaceTest, TheProjectionsLevelKeepsPointsApart) {
  const Pyramid flat = make_pyramid(PyramidKind::kHeight, 64, WrapMode::kClamp, [](int, int, int) { return 0.0; });
  const auto level = [&](double distance, double spacing) {
    return level_of_projection(flat, {{0.0, 0.0, distance}, 64.0 * 100.0}, spacing);
  };
  EXPECT_NEAR(level(100.0, 1.0), 0.0, 0.03);
  EXPECT_NEAR(level(200.0, 1.0), 1.0, 0.03);
  EXPECT_NEAR(level(300.0, 1.0), std::log2(3.0), 0.03);
  EXPECT_NEAR(level(100.0, 8.0), 3.0, 0.03);
  EXPECT_EQ(level(10.0, 1.0), 0.0) << "the level is at least the finest one";
  EXPECT_EQ(level(1e9, 1.0), 6.0) << "the level is at most the coarsest one";
  EXPECT_NEAR(level_of_projection(flat, {{200.0, 0.0, 0.0}, 64.0 * 100.0}, 1.0), 1.0, 0.03) << "seen edge-on";
}

TEST(PyramidSurfaceTest, PatchesAreTheSplineOfTheirControlPoints) {
  // If the control points are in a plane, the patches are in the same plane and reach the border of the control points.
  const Pyramid ramp =
      make_pyramid(PyramidKind::kHeight, 16, WrapMode::kClamp, [](int x, int, int) { return (x + 0.5) / 16.0; });
  const PyramidSurface points = surface_at_level(ramp, 1.0), plane = patches_at_level(ramp, 1.0, 4);
  EXPECT_EQ(plane.columns, 4 * 7 + 1);
  EXPECT_EQ(plane.rows, 4 * 7 + 1);
  EXPECT_EQ(plane.indices.size(), 6u * 28u * 28u);
  EXPECT_LT(glm::distance(plane.positions.front(), points.positions.front()), 1e-6f);
  EXPECT_LT(glm::distance(plane.positions.back(), points.positions.back()), 1e-6f);
  // A cubic B-spline of heights z with evenly spaced control points in one row is (z[-1] + 4 z[0] + z[1]) / 6 at a
  // point, and (z[0] + 23 z[1] + 23 z[2] + z[3]) / 48 midway.
  const Pyramid wave =
      make_pyramid(PyramidKind::kHeight, 16, WrapMode::kClamp, [](int x, int, int) { return 0.2 * std::sin(1.1 * x); });
  const PyramidSurface control = surface_at_level(wave, 0.0), spline = patches_at_level(wave, 0.0, 2);
  const auto z = [&](int i) { return control.positions[static_cast<std::size_t>(5 * 16 + i)].z; };
  const auto found = [&](int i) { return static_cast<std::size_t>(10 * spline.columns + i); };
  EXPECT_NEAR(spline.positions[found(2 * 6)].z, (z(5) + 4.0f * z(6) + z(7)) / 6.0f, 1e-6f);
  EXPECT_NEAR(spline.positions[found(2 * 6 + 1)].z, (z(5) + 23.0f * z(6) + 23.0f * z(7) + z(8)) / 48.0f, 1e-6f);
  const float slope = 15.0f * 0.5f * (z(7) - z(5));  // the slope at the point, along x; the points are 1 / 15 apart
  EXPECT_LT(glm::distance(spline.normals[found(2 * 6)], glm::normalize(glm::vec3(-slope, 0.0f, 1.0f))), 1e-5f);
}

// A closed ring of control points gives a closed surface without a seam.
TEST(PyramidSurfaceTest, PatchesOfPeriodicPositionsAreClosed) {
  constexpr int kSize = 16;
  Pyramid tube = make_pyramid(PyramidKind::kPosition, kSize, WrapMode::kPeriodic, [](int x, int y, int c) {
    const double angle = 2.0 * M_PI * (x + 0.5) / kSize;
    return c == 0 ? std::cos(angle) : c == 1 ? std::sin(angle) : 0.1 * y;
  });
  tube.header.map.wrap_t = WrapMode::kClamp;
  for (const PyramidSurface& surface : {surface_at_level(tube, 0.0), patches_at_level(tube, 0.0, 3)})
    for (int row = 0; row < surface.rows; ++row) {
      const auto first = static_cast<std::size_t>(row * surface.columns);
      const auto last = first + static_cast<std::size_t>(surface.columns) - 1;
      EXPECT_LT(glm::distance(surface.positions[first], surface.positions[last]), 1e-6f);
      EXPECT_LT(glm::distance(surface.normals[first], surface.normals[last]), 1e-5f);
    }
}

class PyramidModesTest : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_ / name; }
  ChildResult view(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), std::string(MULTUM_BIN_DIR) + "/multum-view");
    arguments.insert(arguments.end(), {"-o", path("out.png"), "--context", "osmesa", "--size", "48x32"});
    return run_child(arguments);
  }
  void expect_refusal(const std::vector<std::string>& arguments, int code,
                      const std::vector<std::string>& parts) const {
    const ChildResult result = view(arguments);
    EXPECT_EQ(result.exit_code, code) << result.output;
    testing::expect_says(result.output, parts);
    EXPECT_FALSE(std::filesystem::exists(path("out.png")));
  }
  void write(const Pyramid& pyramid, const std::string& name) const {
    PyramidWriter writer(path(name), pyramid.header, {});
    for (int l = 0; l < pyramid.header.level_count(); ++l)
      writer.write_level(l, 0, pyramid.levels[static_cast<std::size_t>(l)]);
    writer.commit(nullptr);
  }
  std::string triangle() const {
    testing::write_bytes(path("t.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    return path("t.obj");
  }
  TemporaryFolder folder_;
};

TEST_F(PyramidModesTest, AColourPyramidOnThePlane) {
  write(make_pyramid(PyramidKind::kColour, 16, WrapMode::kPeriodic, [](int x, int y, int) { return (x ^ y) & 1; }),
        "a.exr");
  const ChildResult result = view({"pyramid", path("a.exr"), "--lookup", "nearest,reference,level,driver", "--samples",
                                   "16", "--report", path("r.json")});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  std::ifstream file(path("r.json"));
  const nlohmann::json rows = nlohmann::json::parse(file)["pictures"];
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[0]["name"], "reference");
  EXPECT_LT(rows[2]["relative_l1"].get<double>(), 0.75 * rows[1]["relative_l1"].get<double>()) << "mip against nearest";
}

TEST_F(PyramidModesTest, ASurfaceAtALevel) {
  write(make_pyramid(PyramidKind::kHeight, 16, WrapMode::kClamp, [](int x, int, int) { return 0.01 * x; }), "h.exr");
  const ChildResult result = view({"lod", path("h.exr"), "--level", "1.5"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("level 1.5: 6 x 6 points, 50 triangles"), std::string::npos) << result.output;
}

TEST_F(PyramidModesTest, ASurfaceByItsProjectionAndInPatches) {
  write(make_pyramid(PyramidKind::kHeight, 64, WrapMode::kClamp, [](int, int, int) { return 0.0; }), "h.exr");
  // The picture has 32 pixels and an angle of view of 90 degrees. A unit at distance 1 is 16 pixels, so points are 16 /
  // 63 pixels apart.
  const std::vector<std::string> above = {"lod", path("h.exr"), "--camera", "0,0,1,0,0,0,90"};
  const auto drawn = [&](std::vector<std::string> more) {
    more.insert(more.begin(), above.begin(), above.end());
    const ChildResult result = view(more);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return result.output;
  };
  testing::expect_says(drawn({"--point-spacing", "2"}), {"level 3.", ": 8 x 8 points"});
  testing::expect_says(drawn({"--level", "3", "--patches", "5"}), {"level 3: 36 x 36 points"});
  std::filesystem::remove(path("out.png"));
  expect_refusal({"lod", path("h.exr"), "--level", "1", "--point-spacing", "1"}, 2, {"--point-spacing", "--level"});
}

// Bumps that are smaller than a pixel cause aliasing. A coarser surface level does not have such bumps, but the
// reference keeps them.
TEST_F(PyramidModesTest, ReflectedLightOnASurfaceOfLimitedCurvature) {
  write(make_pyramid(PyramidKind::kHeight, 64, WrapMode::kClamp,
                     [](int x, int y, int) { return 0.01 * std::sin(1.5 * x) * std::sin(1.5 * y); }),
        "h.exr");
  const std::string lights = path("lights.exr");
  const ChildResult made = run_child({std::string(MULTUM_BIN_DIR) + "/multum", "reflectance", "-o", lights, "--brdf",
                                      "blinn-phong:100", "--light", "0.3,0.8,0.5", "--size", "64"});
  ASSERT_EQ(made.exit_code, 0) << made.output;
  const auto error_at = [&](const std::string& level) {
    const ChildResult result =
        view({"pyramid", lights, "--surface", path("h.exr"), "--surface-level", level, "--lookup", "reference,bilinear",
              "--samples", "16", "--report", path("r.json"), "--pictures", path("l" + level)});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    std::ifstream file(path("r.json"));
    return nlohmann::json::parse(file)["pictures"][1]["relative_l1"].get<double>();
  };
  const double finest = error_at("0"), limited = error_at("4");
  EXPECT_LT(limited, 0.8 * finest);
  const auto bytes = [&](const std::string& name) { return testing::read_bytes(path(name)); };
  EXPECT_EQ(bytes("l0_reference.png"), bytes("l4_reference.png"));
  EXPECT_NE(bytes("l0_bilinear.png"), bytes("l4_bilinear.png"));
  std::filesystem::remove(path("out.png"));
  expect_refusal({"pyramid", lights, "--mesh", triangle(), "--surface-level", "1"}, 2,
                 {"--surface-level", "require --surface"});
  expect_refusal({"pyramid", lights, "--mesh", triangle(), "--surface", path("h.exr")}, 2,
                 {"two", "--mesh or --surface"});
}

TEST_F(PyramidModesTest, WrongSubjectsAreRefused) {
  write(make_pyramid(PyramidKind::kColour, 4, WrapMode::kPeriodic, [](int, int, int) { return 1; }), "a.exr");
  const std::string a = path("a.exr");
  expect_refusal({}, 2, {"file", "required"});
  expect_refusal({"pyramid"}, 2, {"multum-view pyramid: ", "file", "required", "'multum-view pyramid --help'"});
  expect_refusal({"pyramid", a, "--mesh", triangle()}, 2, {"a.exr", "found --mesh"});
  expect_refusal({"pyramid", a, "--compare", "reference"}, 2, {"unknown option '--compare'"});
  expect_refusal({"pyramid", a, "--lookup", "best"}, 2, {"--lookup", "reference"});
  expect_refusal({"pyramid", a, "--shifts", "4"}, 2, {"reference", "--lookup"});
  expect_refusal({"lod", a}, 3, {"a.exr", "pyramid of colours"});
  expect_refusal({"pyramid", path("none.exr")}, 3, {"none.exr"});
  expect_refusal({a}, 3, {"a.exr", "'pyramid of colours'"});
  expect_refusal({"model", triangle(), "--material", "a=b"}, 3, {"glTF"});
  write(make_pyramid(PyramidKind::kHeight, 4, WrapMode::kPeriodic, [](int, int, int) { return 1; }), "h.exr");
  expect_refusal({"pyramid", path("h.exr")}, 3, {"h.exr", "pyramid of heights", "colours or reflected light"});
}

// Draws two triangles of two materials, of which only one has a map.
TEST_F(PyramidModesTest, AModelWithItsOwnMaterials) {
  write_movmf_mipmap(path("map.ndf.exr"), gl::make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, false).mipmap, {});
  const std::string positions =
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAA"
      "AIA/AAAAAAAAAAAAAIA/";
  const std::string primitive = R"({"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":)";
  testing::write_bytes(
      path("m.gltf"),
      R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0,1]}],"nodes":[{"mesh":0},)"
      R"({"mesh":1,"translation":[0,0,0.5]}],)"
      R"("meshes":[{"primitives":[)" +
          primitive + "0}]},{\"primitives\":[" + primitive +
          R"(1}]}],"materials":[{"name":"red","doubleSided":true,"pbrMetallicRoughness":)"
          R"({"baseColorFactor":[1,0,0,1],"metallicFactor":0}},)"
          R"({"name":"rough"}],"buffers":[{"byteLength":60,"uri":"data:application/octet-stream;base64,)" +
          positions +
          R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24}],)"
          R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
          R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}]})");
  const std::string map = path("map.ndf.exr");
  const ChildResult result = view({"model", path("m.gltf"), "--material", "red=" + map});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("red: 1 triangles, " + map), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("rough: 1 triangles, no map"), std::string::npos) << result.output;
  std::filesystem::remove(path("out.png"));
  expect_refusal({"model", path("m.gltf"), "--material", "blue=" + map}, 2, {"blue", "red, rough"});
  expect_refusal({"model", path("m.gltf"), "--material", "red"}, 2, {"--material", "NAME=FILE"});
  expect_refusal({"model", path("m.gltf"), "--material", "red=" + map, "--material", "red=" + map}, 2, {"twice"});
}

}  // namespace
}  // namespace multum
