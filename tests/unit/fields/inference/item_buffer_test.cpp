// SPDX-License-Identifier: Apache-2.0
// Compares the item buffer with ray casting on random triangles, a cube, triangles that cross the near plane, and
// shared edges through pixel centres.
#include "host/fields/inference/mapping/item_buffer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/ext/matrix_clip_space.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <limits>
#include <random>

namespace multum {
namespace {

constexpr double kNear = 0.1;

struct Hit {
  int triangle = -1;
  double depth = std::numeric_limits<double>::infinity();
  double margin = 0.0;  // the smallest absolute barycentric coordinate of all tests, which says how close the decision
                        // was
};

// Casts a ray through the centre of pixel (x, y), in camera space (Moeller and Trumbore 1997).
Hit cast_ray(const ObjectMesh& mesh, const glm::dmat4& projection, int width, int height, int x, int y) {
  const glm::dvec3 direction((2.0 * (x + 0.5) / width - 1.0) / projection[0][0],
                             (1.0 - 2.0 * (y + 0.5) / height) / projection[1][1], -1.0);
  Hit best;
  best.margin = 1.0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::dvec3 a(mesh.positions[mesh.indices[i]]), b(mesh.positions[mesh.indices[i + 1]]),
        c(mesh.positions[mesh.indices[i + 2]]);
    const glm::dvec3 p = glm::cross(direction, c - a), q = glm::cross(-a, b - a);
    const double det = glm::dot(b - a, p);
    const double s = glm::dot(-a, p) / det, t = glm::dot(direction, q) / det, depth = glm::dot(c - a, q) / det;
    if (depth < kNear * 0.999) continue;
    const double inside = std::min({s, t, 1.0 - s - t});
    best.margin = std::min({best.margin, std::abs(inside), std::abs(depth - kNear), std::abs(depth - best.depth)});
    if (inside >= 0.0 && depth >= kNear && depth < best.depth) {
      best.depth = depth;
      best.triangle = static_cast<int>(i / 3);
    }
  }
  return best;
}

// Every pixel must agree with its ray, unless the decision for the ray is closer than `margin`. Returns the number of
// these exceptions.
int undecided_pixels(const ObjectMesh& mesh, int width, int height, double margin) {
  const glm::dmat4 projection = glm::perspective(1.0, static_cast<double>(width) / height, kNear, 100.0);
  const ItemBuffer items = draw_item_buffer({{&mesh, glm::dmat4(1.0)}}, projection, width, height);
  int undecided = 0;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const Hit hit = cast_ray(mesh, projection, width, height, x, y);
      const auto pixel = static_cast<std::size_t>(y * width + x);
      if (hit.margin < margin) {
        ++undecided;
        continue;
      }
      EXPECT_EQ(items.triangle[pixel], hit.triangle) << "pixel " << x << ", " << y << ", margin " << hit.margin;
      EXPECT_EQ(items.object[pixel], hit.triangle < 0 ? -1 : 0);
      if (hit.triangle >= 0) EXPECT_NEAR(items.depth[pixel], hit.depth, 2e-3 * hit.depth);
      else EXPECT_TRUE(std::isinf(items.depth[pixel]));
    }
  return undecided;
}

ObjectMesh triangles(const std::vector<glm::vec3>& positions) {
  ObjectMesh mesh;
  mesh.positions = positions;
  mesh.uvs.resize(positions.size());
  for (std::size_t i = 0; i < positions.size(); ++i) mesh.indices.push_back(static_cast<std::uint32_t>(i));
  return mesh;
}

TEST(ItemBufferTest, RandomTrianglesAgreeWithRayCasting) {
  const unsigned seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> across(-2.0f, 2.0f), along(-5.0f, 1.5f);  // some triangles are behind the eye
  int undecided = 0;
  for (int round = 0; round < 20; ++round) {
    std::vector<glm::vec3> positions;
    for (int i = 0; i < 3 * 12; ++i) positions.emplace_back(across(random), across(random), along(random));
    undecided += undecided_pixels(triangles(positions), 61, 40, 2e-3);
  }
  EXPECT_LT(undecided, 20 * 61 * 40 / 8);
}

TEST(ItemBufferTest, ATriangleThroughTheNearPlaneIsCutThere) {
  // A floor from behind the eye to in front of it covers the picture's bottom rows.
  const ObjectMesh floor = triangles({{-50.0f, -1.0f, 5.0f}, {50.0f, -1.0f, 5.0f}, {0.0f, -1.0f, -60.0f}});
  EXPECT_LT(undecided_pixels(floor, 64, 48, 1e-4), 64);
  const glm::dmat4 projection = glm::perspective(1.0, 64.0 / 48.0, kNear, 100.0);
  const ItemBuffer items = draw_item_buffer({{&floor, glm::dmat4(1.0)}}, projection, 64, 48);
  EXPECT_EQ(items.triangle[47 * 64 + 32], 0);  // bottom row
  EXPECT_EQ(items.triangle[32], -1);           // top row
  // The ray through row y falls by tan(0.5) (2 (y + 0.5)/48 - 1) per unit of depth, so it meets y = -1 at a depth of 1
  // over this number.
  EXPECT_NEAR(items.depth[47 * 64 + 32], 1.0 / (std::tan(0.5) * (47.0 / 48.0)), 1e-3);
  const ObjectMesh behind = triangles({{-1.0f, -1.0f, 1.0f}, {1.0f, -1.0f, 1.0f}, {0.0f, 1.0f, 2.0f}});
  for (const std::int32_t object : draw_item_buffer({{&behind, glm::dmat4(1.0)}}, projection, 64, 48).object)
    EXPECT_EQ(object, -1);
}

TEST(ItemBufferTest, ACubeShowsItsNearestFaces) {
  ObjectMesh cube;
  for (int i = 0; i < 8; ++i)
    cube.positions.emplace_back(i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f);
  cube.uvs.resize(8);
  cube.indices = {0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1,
                  2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
  const glm::dmat4 projection = glm::perspective(0.8, 1.0, kNear, 100.0);
  const glm::dmat4 at = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 0.0, -6.0));
  const ItemBuffer front = draw_item_buffer({{&cube, at}}, projection, 100, 100);
  // From the front, only the face z = +1 (triangles 2 and 3) is visible. Its depth is 5 everywhere.
  const double half = 1.0 / (5.0 * std::tan(0.4)) * 50.0;  // pixels
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) {
      const bool inside = std::abs(x + 0.5 - 50.0) < half && std::abs(y + 0.5 - 50.0) < half;
      const auto pixel = static_cast<std::size_t>(y * 100 + x);
      ASSERT_EQ(front.object[pixel], inside ? 0 : -1) << x << ", " << y;
      if (!inside) continue;
      EXPECT_TRUE(front.triangle[pixel] == 2 || front.triangle[pixel] == 3);
      EXPECT_NEAR(front.depth[pixel], 5.0, 1e-6);
    }
  // The nearer of two objects is visible, whichever is drawn first. The top row shows the upper object.
  const glm::dmat4 nearer = glm::translate(glm::dmat4(1.0), glm::dvec3(0.0, 1.2, -4.0));
  const ItemBuffer a = draw_item_buffer({{&cube, at}, {&cube, nearer}}, projection, 100, 100);
  const ItemBuffer b = draw_item_buffer({{&cube, nearer}, {&cube, at}}, projection, 100, 100);
  EXPECT_EQ(a.object[50], 1);
  EXPECT_EQ(a.object[70 * 100 + 50], 0);
  for (std::size_t i = 0; i < a.object.size(); ++i) EXPECT_EQ(a.object[i] < 0 ? -1 : 1 - a.object[i], b.object[i]);
  EXPECT_EQ(a.triangle, b.triangle);
  EXPECT_EQ(a.depth, b.depth);
}

TEST(ItemBufferTest, SharedEdgesMissNoPixelAndDrawNoneTwice) {
  // Draws triangles around a centre, with all corners on pixel centres, in an orthographic picture. If each triangle is
  // drawn separately, each inner pixel belongs to exactly one triangle.
  constexpr int kSize = 64, kSpokes = 16;
  const glm::dmat4 projection = glm::ortho(0.0, double{kSize}, double{kSize}, 0.0, -1.0, 1.0);  // y downwards
  std::mt19937 random(3);
  std::uniform_int_distribution<int> wobble(-4, 4);
  for (int round = 0; round < 20; ++round) {
    std::vector<glm::vec3> rim;
    for (int i = 0; i < kSpokes; ++i) {
      const double angle = i * 6.283185307179586 / kSpokes;
      const double radius = 24.0 + wobble(random);
      rim.emplace_back(std::floor(32.0 + radius * std::cos(angle)) + 0.5,
                       std::floor(32.0 + radius * std::sin(angle)) + 0.5, 0);
    }
    const glm::vec3 centre(32.5f, 31.5f, 0.0f);
    std::vector<int> count(kSize * kSize, 0);
    std::vector<glm::vec3> all;
    for (std::size_t i = 0; i < kSpokes; ++i) {
      std::vector<glm::vec3> one = {centre, rim[i], rim[(i + 1) % kSpokes]};
      if (i % 3 == 0) std::swap(one[1], one[2]);  // tries both orientations
      all.insert(all.end(), one.begin(), one.end());
      const ObjectMesh mesh = triangles(one);
      const ItemBuffer items = draw_item_buffer({{&mesh, glm::dmat4(1.0)}}, projection, kSize, kSize);
      for (std::size_t p = 0; p < count.size(); ++p) count[p] += items.object[p] == 0;
    }
    const ObjectMesh mesh = triangles(all);
    const ItemBuffer items = draw_item_buffer({{&mesh, glm::dmat4(1.0)}}, projection, kSize, kSize);
    int inner = 0;
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const auto pixel = static_cast<std::size_t>(y * kSize + x);
        ASSERT_LE(count[pixel], 1) << x << ", " << y;
        ASSERT_EQ(count[pixel] == 1, items.object[pixel] == 0);
        if (std::hypot(x + 0.5 - 32.0, y + 0.5 - 32.0) < 18.0) {
          ASSERT_EQ(count[pixel], 1) << x << ", " << y;
          ++inner;
        }
      }
    EXPECT_GT(inner, 900);
  }
}

TEST(ItemBufferTest, AFineWallInPerspectiveHasNoHoles) {
  // A tilted wall is cut into many small triangles. Together, they must cover the same pixels as a wall of two
  // triangles.
  const unsigned seed = 11;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> wobble(-0.02f, 0.02f);
  constexpr std::uint32_t kCells = 24;
  ObjectMesh fine;
  for (std::uint32_t y = 0; y <= kCells; ++y)
    for (std::uint32_t x = 0; x <= kCells; ++x) {
      const bool rim = x == 0 || y == 0 || x == kCells || y == kCells;
      const float u = static_cast<float>(x) / kCells * 2.0f - 1.0f, v = static_cast<float>(y) / kCells * 2.0f - 1.0f;
      fine.positions.emplace_back(u + (rim ? 0.0f : wobble(random)), v + (rim ? 0.0f : wobble(random)), 0.0f);
    }
  fine.uvs.resize(fine.positions.size());
  for (std::uint32_t y = 0; y < kCells; ++y)
    for (std::uint32_t x = 0; x < kCells; ++x) {
      const std::uint32_t a = y * (kCells + 1) + x, b = a + 1, c = a + kCells + 1, d = c + 1;
      for (const std::uint32_t i : {a, b, d, a, d, c}) fine.indices.push_back(i);
    }
  const ObjectMesh coarse = triangles({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, -1, 0}, {1, 1, 0}, {-1, 1, 0}});
  const glm::dmat4 at =
      glm::rotate(glm::translate(glm::dmat4(1.0), glm::dvec3(0.1, 0.2, -1.3)), 1.0, glm::dvec3(1, 0.3, 0));
  const glm::dmat4 projection = glm::perspective(1.2, 1.5, kNear, 100.0);
  const ItemBuffer a = draw_item_buffer({{&fine, at}}, projection, 300, 200);
  const ItemBuffer b = draw_item_buffer({{&coarse, at}}, projection, 300, 200);
  int different = 0, covered = 0;
  for (std::size_t i = 0; i < a.object.size(); ++i) {
    different += a.object[i] != b.object[i];
    covered += b.object[i] == 0;
  }
  EXPECT_GT(covered, 4000);
  EXPECT_LE(different, 2);  // each corner on the edge of the wall is rounded to 2^-14 pixels
}

TEST(ItemBufferTest, CoverageIsTheShareOfSubPixels) {
  // There are two adjacent pixels of 2 x 2 sub-pixels each.
  ItemBuffer items;
  items.width = 4;
  items.height = 2;
  items.object = {0, 1, 1,  1,  //
                  0, 0, -1, 1};
  const std::vector<std::vector<float>> coverage = item_coverage(items, 2, 3);
  EXPECT_EQ(coverage, (std::vector<std::vector<float>>{{0.75f, 0.0f}, {0.25f, 0.75f}, {0.0f, 0.0f}}));
  EXPECT_EQ(item_coverage(items, 1, 1 + 1)[0], (std::vector<float>{1, 0, 0, 0, 1, 1, 0, 0}));
}

}  // namespace
}  // namespace multum
