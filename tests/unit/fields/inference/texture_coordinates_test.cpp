// SPDX-License-Identifier: Apache-2.0
// Tests texture coordinates for inference on scenes with closed forms: planes that are seen head-on and in perspective,
// and cylinders with a visible seam. Compares the stretch with finite differences from ray casting, and the gradient of
// eq. 7 with finite differences of eq. 7.
#include "host/fields/inference/mapping/texture_coordinates.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <memory>
#include <numbers>
#include <random>
#include <set>

#include "host/fields/inference/mapping/isometric_map.h"
#include "host/fields/inference/mapping/visible_pixels.h"

namespace multum {
namespace {

constexpr double kFieldOfView = 1.0;  // vertical, radians
constexpr int kSize = 320;            // in pixels; the pictures are square

// Makes cells x cells quads over [-1, 1]^2 in the plane z = 0, with u and v from 0 to uv_size.
ObjectMesh plane(int cells, glm::dvec2 uv_size, double uv_angle = 0.0) {
  ObjectMesh mesh;
  for (int y = 0; y <= cells; ++y)
    for (int x = 0; x <= cells; ++x) {
      const glm::dvec2 at(static_cast<double>(x) / cells, static_cast<double>(y) / cells);
      const double c = std::cos(uv_angle), s = std::sin(uv_angle);
      mesh.positions.emplace_back(2.0 * at.x - 1.0, 2.0 * at.y - 1.0, 0.0);
      mesh.uvs.emplace_back(glm::dmat2(c, s, -s, c) * (at * uv_size));
    }
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const auto a = static_cast<std::uint32_t>(y * (cells + 1) + x), b = a + static_cast<std::uint32_t>(cells) + 1;
      for (const std::uint32_t i : {a, a + 1, b + 1, a, b + 1, b}) mesh.indices.push_back(i);
    }
  return mesh;
}

// Makes a cylinder around the y axis: radius 1, y from -1 to 1. The coordinate u runs once around from `u_start`; at
// u_start = 0 the seam faces +z.
ObjectMesh cylinder(int sides, double u_start) {
  ObjectMesh mesh;
  for (int i = 0; i <= sides; ++i)
    for (int k = 0; k < 2; ++k) {
      const double angle = 2.0 * std::numbers::pi * (i % sides) / sides;
      mesh.positions.emplace_back(std::sin(angle), 2.0 * k - 1.0, std::cos(angle));
      mesh.uvs.emplace_back(u_start + static_cast<double>(i) / sides, k);
    }
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(sides); ++i)
    for (const std::uint32_t corner : {0u, 2u, 3u, 0u, 3u, 1u}) mesh.indices.push_back(2 * i + corner);
  return mesh;
}

// Holds the views of one object and the item buffers to which the views point.
class Views {
 public:
  explicit Views(const ObjectMesh& mesh) : mesh_(mesh) {}
  void add(const glm::dmat4& object_to_camera) {
    const glm::dmat4 projection = glm::perspective(kFieldOfView, 1.0, 0.1, 100.0);
    items_.push_back(
        std::make_unique<ItemBuffer>(draw_item_buffer({{&mesh_, object_to_camera}}, projection, kSize, kSize)));
    views.push_back({object_to_camera, projection, items_.back().get(), 0});
  }
  std::vector<MappingView> views;

 private:
  const ObjectMesh& mesh_;
  std::vector<std::unique_ptr<ItemBuffer>> items_;
};

glm::dmat4 at_distance(double distance) { return glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, -distance)); }

// Returns the distance at which one unit of a plane seen head-on spans `pixels` pixels.
double distance_for(double pixels) { return 0.5 * kSize / std::tan(0.5 * kFieldOfView) / pixels; }

AnimationTexture settings_for(const char* wrap = "clamp") {
  AnimationTexture texture;
  texture.wrap = wrap;
  texture.side_max = 16384;
  return texture;
}

// Intersects the ray through a point on the screen with the plane of a triangle. Returns the barycentric coordinates,
// which Cramer's rule gives.
glm::dvec3 cast(const ObjectMesh& mesh, const MappingView& view, std::size_t triangle, glm::dvec2 screen) {
  const glm::dvec3 ray((2.0 * screen.x / kSize - 1.0) / view.projection[0][0],
                       (1.0 - 2.0 * screen.y / kSize) / view.projection[1][1], -1.0);
  std::array<glm::dvec3, 3> p;
  for (std::size_t i = 0; i < 3; ++i)
    p[i] =
        glm::dvec3(view.object_to_camera * glm::dvec4(glm::dvec3(mesh.positions[mesh.indices[3 * triangle + i]]), 1));
  const glm::dvec3 share(glm::dot(ray, glm::cross(p[1], p[2])), glm::dot(ray, glm::cross(p[2], p[0])),
                         glm::dot(ray, glm::cross(p[0], p[1])));
  return share / (share.x + share.y + share.z);
}

struct Seen {
  double stretch_max = 0.0;
  glm::dvec2 low{1e30}, high{-1e30};  // in texels from the corner of the texture
};

// Measures all visible pixels, using only mapped_corners() and finite differences.
Seen look_at_pixels(const ObjectMesh& mesh, const Views& views, const TextureMapping& mapping) {
  const std::vector<glm::vec2> corners = mapped_corners(mesh.uvs, mesh.indices, mapping);
  Seen seen;
  for (const MappingView& view : views.views)
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const auto pixel = static_cast<std::size_t>(y * kSize + x);
        if (view.items->object[pixel] != 0) continue;
        const auto triangle = static_cast<std::size_t>(view.items->triangle[pixel]);
        const auto texel = [&](double dx, double dy) {
          const glm::dvec3 share = cast(mesh, view, triangle, {x + 0.5 + dx, y + 0.5 + dy});
          glm::dvec2 at(0.0);
          for (glm::length_t i = 0; i < 3; ++i)
            at += share[i] * glm::dvec2(corners[3 * triangle + static_cast<std::size_t>(i)]);
          return at * glm::dvec2(mapping.width, mapping.height);
        };
        constexpr double h = 1e-3;
        const glm::dmat2 jacobian((texel(h, 0) - texel(-h, 0)) / (2 * h), (texel(0, h) - texel(0, -h)) / (2 * h));
        const glm::dmat2 to_screen = glm::inverse(jacobian);
        const glm::dmat2 g = glm::transpose(to_screen) * to_screen;
        const double trace = g[0][0] + g[1][1];
        seen.stretch_max =
            std::max(seen.stretch_max,
                     std::sqrt(0.5 * (trace + std::sqrt(std::max(0.0, trace * trace - 4 * glm::determinant(g))))));
        seen.low = glm::min(seen.low, texel(0, 0));
        seen.high = glm::max(seen.high, texel(0, 0));
      }
  return seen;
}

// Checks two properties of every mapping: the stated stretch equals the measured stretch, and no visible point is
// outside the texture.
void expect_sound(const ObjectMesh& mesh, const Views& views, const TextureMapping& mapping, double stretch_max) {
  const Seen seen = look_at_pixels(mesh, views, mapping);
  EXPECT_LE(seen.stretch_max, stretch_max * (1.0 + 1e-3));
  EXPECT_NEAR(seen.stretch_max, mapping.stretch_max, 2e-3 * mapping.stretch_max);
  if (mapping.wrap_s == WrapMode::kClamp) {
    EXPECT_GE(seen.low.x, 0.5 - 1e-3);
    EXPECT_LE(seen.high.x, mapping.width - 0.5 + 1e-3);
  }
  if (mapping.wrap_t == WrapMode::kClamp) {
    EXPECT_GE(seen.low.y, 0.5 - 1e-3);
    EXPECT_LE(seen.high.y, mapping.height - 0.5 + 1e-3);
  }
}

TEST(IsometricMapTest, GradientAgreesWithFiniteDifferences) {
  const unsigned seed = 5;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int round = 0; round < 50; ++round) {
    std::vector<IsometricEdge> edges;
    for (int i = 0; i < 20; ++i)
      edges.push_back({{normal(random), normal(random)}, 0.3 + std::abs(normal(random)), std::abs(normal(random))});
    const glm::dmat2 map(normal(random), normal(random), normal(random), normal(random));
    glm::dmat2 gradient;
    const double cost = isometric_cost(edges, map, &gradient);
    for (glm::length_t c = 0; c < 2; ++c)
      for (glm::length_t r = 0; r < 2; ++r) {
        constexpr double h = 1e-6;
        glm::dmat2 above = map, below = map;
        above[c][r] += h;
        below[c][r] -= h;
        const double difference =
            (isometric_cost(edges, above, nullptr) - isometric_cost(edges, below, nullptr)) / (2 * h);
        const double size = std::sqrt(glm::dot(gradient[0], gradient[0]) + glm::dot(gradient[1], gradient[1]));
        EXPECT_NEAR(gradient[c][r], difference, 1e-4 * size + 1e-8 * cost);
      }
  }
}

TEST(IsometricMapTest, FindsAnIsometryWhereThereIsOneAndALocalMinimumElsewhere) {
  std::mt19937 random(9);
  std::normal_distribution<double> normal;
  const glm::dmat2 reference(300.0, -40.0, 55.0, 8.0);
  std::vector<IsometricEdge> edges;
  for (int i = 0; i < 30; ++i) {
    const glm::dvec2 uv(normal(random), normal(random));
    edges.push_back({uv, glm::length(reference * uv), 1.0 + std::abs(normal(random))});
  }
  const glm::dmat2 found = fit_isometric_map(edges, glm::dmat2(100.0, 0.0, 0.0, 100.0), {});
  const glm::dmat2 metric = glm::transpose(reference) * reference, metric_found = glm::transpose(found) * found;
  for (glm::length_t c = 0; c < 2; ++c)
    for (glm::length_t r = 0; r < 2; ++r) EXPECT_NEAR(metric_found[c][r], metric[c][r], 1e-3 * metric[0][0]);
  for (IsometricEdge& edge : edges) edge.length *= std::exp(0.5 * normal(random));
  for (const bool is_diagonal : {false, true}) {
    IsometricSettings settings;
    settings.is_diagonal = is_diagonal;
    const glm::dmat2 best = fit_isometric_map(edges, glm::dmat2(100.0, 0.0, 0.0, 30.0), settings);
    const double cost = isometric_cost(edges, best, nullptr);
    for (int i = 0; i < 200; ++i) {
      glm::dmat2 near = best + 1e-2 * glm::dmat2(normal(random), normal(random), normal(random), normal(random)) * best;
      if (is_diagonal) near[0][1] = near[1][0] = 0.0;
      EXPECT_GE(isometric_cost(edges, near, nullptr), cost * (1.0 - 1e-9));
    }
    EXPECT_EQ(best[0][1] == 0.0 && best[1][0] == 0.0, is_diagonal);
  }
}

TEST(TextureMappingTest, APlaneHeadOnHasTheScreensResolutionOverTheThreshold) {
  for (const int cells : {1, 6}) {
    const ObjectMesh mesh = plane(cells, {1.0, 1.0});
    Views views(mesh);
    views.add(at_distance(distance_for(100.0)));  // the scale is 100 pixels per unit, and the plane spans 200 pixels
    const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for());
    EXPECT_NEAR(mapping.width, 160 + 1, 1) << "plus half a texel at each end";
    EXPECT_NEAR(mapping.height, 160 + 1, 1);
    EXPECT_LE(mapping.stretch_max, 1.25 * (1 + 1e-9));
    EXPECT_NEAR(mapping.stretch_max, 1.25, 1.25 / 160);
    EXPECT_NEAR(static_cast<double>(mapping.visible_pixels), 200.0 * 200.0, 801.0);
    EXPECT_EQ(mapping.degenerate_pixels, 0u);
    expect_sound(mesh, views, mapping, 1.25);
  }
}

TEST(TextureMappingTest, SettingsOfTheResolutionAreKept) {
  const ObjectMesh mesh = plane(2, {1.0, 1.0});
  Views views(mesh);
  views.add(at_distance(distance_for(100.0)));
  AnimationTexture texture = settings_for();
  texture.resolution_scale = 0.5;
  EXPECT_NEAR(optimise_texture_mapping(mesh, views.views, texture).width, 81, 1);
  texture.power_of_two = true;
  EXPECT_EQ(optimise_texture_mapping(mesh, views.views, texture).width, 128);
  texture.side_max = 100;
  EXPECT_EQ(optimise_texture_mapping(mesh, views.views, texture).width, 64);
  texture.power_of_two = false;
  texture.side_max = 31;
  const TextureMapping small = optimise_texture_mapping(mesh, views.views, texture);
  EXPECT_EQ(small.width, 31);
  EXPECT_NEAR(small.stretch_max, 200.0 / 30.0, 1e-3) << "the stretch is stated although it exceeds the threshold";
  expect_sound(mesh, views, small, 6.7);
  texture.side_max = 1;
  EXPECT_EQ(optimise_texture_mapping(mesh, views.views, texture).width, 1);
}

TEST(TextureMappingTest, ScaledAndTurnedCoordinatesGiveTheSameTexture) {
  const glm::dmat4 view = at_distance(distance_for(100.0));
  for (const double angle : {0.0, std::numbers::pi / 6.0, 1.0})
    for (const double factor : {1.0, 7.0, 0.01}) {
      const ObjectMesh mesh = plane(4, {factor, 1.0}, angle);
      Views views(mesh);
      views.add(view);
      const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for());
      EXPECT_LE(mapping.width * mapping.height, 161 * 161 * 1.02) << factor << " turned by " << angle;
      EXPECT_GE(mapping.width * mapping.height, 160 * 160);
      expect_sound(mesh, views, mapping, 1.25);
    }
}

TEST(TextureMappingTest, APlaneTurnedOnTheScreenTakesNoLargerRectangle) {
  const ObjectMesh mesh = plane(4, {1.0, 1.0});
  Views views(mesh);
  views.add(glm::rotate(at_distance(distance_for(100.0)), std::numbers::pi / 6.0, glm::dvec3(0, 0, 1)));
  const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for());
  EXPECT_LE(mapping.width * mapping.height, 161 * 161 * 1.02);
  expect_sound(mesh, views, mapping, 1.25);
}

TEST(TextureMappingTest, PerspectivePlanesHoldTheThresholdAtEveryPixel) {
  for (const int cells : {1, 5}) {
    const ObjectMesh mesh = plane(cells, {3.0, 1.0});
    Views views(mesh);
    // The views are from low above the plane. One view cuts off the near end, and in the last view the plane passes
    // under the eye.
    for (const double distance : {2.2, 1.4, 0.9})
      views.add(glm::rotate(
          glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(0.1, -0.3, -distance)), -1.2, glm::dvec3(1, 0.3, 0)),
          0.4, glm::dvec3(0, 0, 1)));
    AnimationTexture texture = settings_for();
    const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, texture);
    EXPECT_GT(mapping.stretch_max, 1.2);
    EXPECT_LE(mapping.stretch_max, 1.25);
    EXPECT_LE(mapping.stretch_rounds, 20);
    expect_sound(mesh, views, mapping, 1.25);
    EXPECT_LT(mapping.width, 6000);
  }
}

TEST(TextureMappingTest, OnlyWhatIsVisibleTakesTexels) {
  // Seen head-on from near, the plane is four times as wide as the screen.
  const ObjectMesh mesh = plane(1, {1.0, 1.0});
  Views views(mesh);
  views.add(at_distance(distance_for(640.0)));
  const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for());
  EXPECT_NEAR(mapping.width, (kSize + 2) / 1.25 + 1, 2);
  expect_sound(mesh, views, mapping, 1.25);
}

TEST(TextureMappingTest, ACutThroughTheHiddenSideOfACylinderSavesTexels) {
  for (const double u_start : {0.0, 0.5, -3.2}) {  // the seam is in front, behind, and at another place
    const ObjectMesh mesh = cylinder(48, u_start);
    Views views(mesh);
    views.add(at_distance(5.0));
    const TextureMapping cut = optimise_texture_mapping(mesh, views.views, settings_for("periodic"));
    const TextureMapping uncut = optimise_texture_mapping(mesh, views.views, settings_for("clamp"));
    EXPECT_TRUE(cut.has_cut[0]);
    EXPECT_FALSE(cut.has_cut[1]) << "v ends at 0 and 1 without a seam";
    EXPECT_EQ(cut.wrap_s, WrapMode::kClamp);
    EXPECT_EQ(cut.wrap_t, WrapMode::kClamp);
    // With the seam in front, both ends of the period are visible, and the uncut texture spans nearly the whole period.
    EXPECT_LE(cut.width * cut.height, (u_start == 0.0 ? 0.6 : 1.02) * uncut.width * uncut.height);
    expect_sound(mesh, views, cut, 1.25);
    // No triangle is torn apart. Each triangle keeps its shape, and the range of s of a visible triangle is inside the
    // texture.
    const std::vector<glm::vec2> corners = mapped_corners(mesh.uvs, mesh.indices, cut);
    for (std::size_t i = 0; i < corners.size(); i += 3)
      for (const std::size_t k : {i + 1, i + 2}) {
        const glm::dvec2 uv(mesh.uvs[mesh.indices[k]] - mesh.uvs[mesh.indices[i]]);
        EXPECT_LT(glm::distance(cut.linear * uv, glm::dvec2(corners[k] - corners[i])), 1e-5);
      }
    std::set<std::int32_t> seen(views.views[0].items->triangle.begin(), views.views[0].items->triangle.end());
    seen.erase(-1);
    EXPECT_GT(seen.size(), 30u);
    for (const std::int32_t triangle : seen)
      for (std::size_t k = 0; k < 3; ++k) {
        EXPECT_GE(corners[3 * static_cast<std::size_t>(triangle) + k].x, 0.0f);
        EXPECT_LE(corners[3 * static_cast<std::size_t>(triangle) + k].x, 1.0f);
      }
  }
}

TEST(TextureMappingTest, ADirectionSeenAllAroundKeepsItsPeriod) {
  const ObjectMesh mesh = cylinder(48, 0.0);
  Views views(mesh);
  for (int i = 0; i < 8; ++i) views.add(glm::rotate(at_distance(5.0), i * std::numbers::pi / 4.0, glm::dvec3(0, 1, 0)));
  const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for("periodic"));
  EXPECT_FALSE(mapping.has_cut[0]);
  EXPECT_EQ(mapping.wrap_s, WrapMode::kPeriodic);
  EXPECT_EQ(mapping.wrap_t, WrapMode::kClamp);
  EXPECT_EQ(mapping.linear[0][0], 1.0) << "the width is one period";
  EXPECT_EQ(mapping.linear[0][1], 0.0);
  EXPECT_EQ(mapping.linear[1][0], 0.0);
  EXPECT_EQ(mapping.offset.x, 0.0);
  // At the nearest point, at distance 4, a unit has 0.5 size / tan / 4 pixels, and 2 pi units are one period.
  const double pixels = 0.5 * kSize / std::tan(0.5 * kFieldOfView) / 4.0;
  EXPECT_NEAR(mapping.width, 2 * std::numbers::pi * pixels / 1.25, 0.02 * mapping.width);
  expect_sound(mesh, views, mapping, 1.25);
}

TEST(TextureMappingTest, RepeatedCoordinatesArePeriodicInBothDirections) {
  const ObjectMesh mesh = plane(8, {4.0, 3.0});
  Views views(mesh);
  views.add(at_distance(distance_for(100.0)));
  const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for("periodic"));
  EXPECT_EQ(mapping.wrap_s, WrapMode::kPeriodic);
  EXPECT_EQ(mapping.wrap_t, WrapMode::kPeriodic);
  EXPECT_EQ(mapping.width, 40);        // 200 / 1.25 / 4
  EXPECT_NEAR(mapping.height, 54, 1);  // 200 / 1.25 / 3
  EXPECT_EQ(mapping.linear, glm::dmat2(1.0));
}

TEST(TextureMappingTest, AnInvisibleObjectHasNoTexture) {
  const ObjectMesh mesh = plane(1, {1.0, 1.0});
  Views views(mesh);
  views.add(at_distance(-5.0));  // behind the eye
  const TextureMapping mapping = optimise_texture_mapping(mesh, views.views, settings_for());
  EXPECT_EQ(mapping.width, 0);
  EXPECT_EQ(mapping.height, 0);
  EXPECT_EQ(mapping.visible_pixels, 0u);
  EXPECT_EQ(optimise_texture_mapping(mesh, {}, settings_for()).width, 0);
}

TEST(TextureMappingTest, TrianglesThatAreALineInTheTextureAreCountedAndHarmless) {
  ObjectMesh mesh = plane(4, {1.0, 1.0});
  Views views(mesh);
  views.add(at_distance(distance_for(100.0)));
  const TextureMapping before = optimise_texture_mapping(mesh, views.views, settings_for());
  // Adds a triangle in front of the plane, with one texture coordinate at all corners.
  const auto first = static_cast<std::uint32_t>(mesh.positions.size());
  for (const glm::vec3 p :
       {glm::vec3(-0.1f, 0.0f, 0.01f), glm::vec3(0.1f, 0.0f, 0.01f), glm::vec3(0.0f, 0.1f, 0.01f)}) {
    mesh.positions.push_back(p);
    mesh.uvs.emplace_back(0.3f, 0.3f);
    mesh.indices.push_back(first + static_cast<std::uint32_t>(mesh.positions.size() - 1 - first));
  }
  Views after_views(mesh);
  after_views.add(at_distance(distance_for(100.0)));
  const TextureMapping after = optimise_texture_mapping(mesh, after_views.views, settings_for());
  EXPECT_GT(after.degenerate_pixels, 50u);
  EXPECT_EQ(after.width, before.width);
  EXPECT_EQ(after.height, before.height);
  EXPECT_TRUE(std::isfinite(after.stretch_max));
  for (glm::vec2& uv : mesh.uvs) uv = glm::vec2(0.25f);  // no other triangle remains
  const TextureMapping nothing = optimise_texture_mapping(mesh, after_views.views, settings_for());
  EXPECT_EQ(nothing.degenerate_pixels, nothing.visible_pixels);
  EXPECT_GE(nothing.width, 1);
  EXPECT_LE(nothing.width, 2);
}

TEST(ConvexHullTest, HoldsAllPointsAndIsConvex) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<glm::dvec2> points;
  for (int i = 0; i < 300; ++i) points.emplace_back(uniform(random), uniform(random));
  const std::vector<glm::dvec2> hull = convex_hull(points);
  ASSERT_GE(hull.size(), 3u);
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const glm::dvec2 a = hull[i], b = hull[(i + 1) % hull.size()];
    for (const glm::dvec2 p : points) EXPECT_GE((b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x), -1e-12);
  }
  EXPECT_EQ(convex_hull({{1, 1}, {1, 1}}).size(), 1u);
  EXPECT_EQ(convex_hull({{0, 0}, {1, 1}, {2, 2}}).size(), 2u);
}

}  // namespace
}  // namespace multum
