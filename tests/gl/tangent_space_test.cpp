// SPDX-License-Identifier: Apache-2.0
// Compares tangents by MikkTSpace's convention with values computed by hand, and tests them on a conformance model.
#include <gtest/gtest.h>

#include <cmath>

#include <glm/geometric.hpp>

#include "host/formats/mesh/gltf_material.h"
#include "host/formats/mesh/mesh.h"
#include "host/formats/mesh/tangent_space.h"
#include "tests/fixtures/shared_data.h"

namespace multum {
namespace {

using testing::shared_data;

struct Corner {
  glm::vec3 position;
  glm::vec2 uv;
};

TriangleCorners flat(const std::vector<Corner>& list) {
  TriangleCorners corners;
  for (const Corner& corner : list) {
    corners.positions.push_back(corner.position);
    corners.normals.emplace_back(0.0f, 0.0f, 1.0f);
    corners.uvs.push_back(corner.uv);
  }
  return corners;
}

void expect_near(const glm::vec4& found, const glm::vec4& expected) {
  EXPECT_LT(glm::distance(found, expected), 1e-5f)
      << found.x << ", " << found.y << ", " << found.z << ", " << found.w << " is not " << expected.x << ", "
      << expected.y << ", " << expected.z << ", " << expected.w;
}

// Two triangles share an edge. In each triangle, u increases in a different direction.
TEST(TangentSpace, CornersWeighByTheirAngles) {
  const Corner a{{0, 0, 0}, {0, 0}}, b{{1, 0, 0}, {1, 0}}, c{{0, 1, 0}, {0, 1}};
  const Corner d{{1, 1, 0}, {3, 1}};
  const std::vector<glm::vec4> tangents = mikk_tangents(flat({a, b, c, b, d, c}));
  // Second triangle: e1 = d - b = (0, 1), e2 = c - b = (-1, 1); duv1 = (2, 1), duv2 = (-1, 1).
  // T ~ duv2.v e1 - duv1.v e2 = (0, 1) - (-1, 1) = (1, 0). Both agree: +x everywhere.
  for (const glm::vec4& t : tangents) expect_near(t, {1, 0, 0, 1});
  // If v increases too, T leans: duv1 = (2, 2), so T ~ 1 (0, 1) - 2 (-1, 1) = (2, -1).
  const Corner e{{1, 1, 0}, {3, 2}};
  const std::vector<glm::vec4> leaning = mikk_tangents(flat({a, b, c, b, e, c}));
  const glm::vec2 second = glm::normalize(glm::vec2(2, -1));
  const auto mixed = [&](float first_angle, float second_angle) {
    const glm::vec2 sum = glm::normalize(first_angle * glm::vec2(1, 0) + second_angle * second);
    return glm::vec4(sum, 0, 1);
  };
  expect_near(leaning[0], {1, 0, 0, 1});
  expect_near(leaning[1], mixed(45, 45));
  expect_near(leaning[2], mixed(45, 45));
  expect_near(leaning[4], glm::vec4(second, 0, 1));
  // A sharper corner counts for less. Here b is moved far out along x, and u still equals x.
  const Corner far{{2, 0, 0}, {2, 0}};
  const std::vector<glm::vec4> weighed = mikk_tangents(flat({a, far, c, far, e, c}));
  // far: first triangle between (-2, 0) and (-2, 1), second between (-1, 1) and (-2, 1).
  const float first_angle = std::atan2(1.0f, 2.0f), second_angle = std::atan(1.0f) - first_angle;
  // Second: e1 = e - far = (-1, 1), e2 = c - far = (-2, 1); duv1 = (1, 2), duv2 = (-2, 1).
  // area = 1 * 1 - 2 * (-2) = 5 > 0; T ~ 1 (-1, 1) - 2 (-2, 1) = (3, -1).
  const glm::vec2 third = glm::normalize(glm::vec2(3, -1));
  expect_near(weighed[1], glm::vec4(glm::normalize(first_angle * glm::vec2(1, 0) + second_angle * third), 0, 1));
}

// A chart and its mirror image share all attributes of the vertices on the seam: positions, normals, and texture
// coordinates.
TEST(TangentSpace, MirroredChartsDoNotMix) {
  const Corner top{{0, 1, 0}, {0, 1}}, bottom{{0, 0, 0}, {0, 0}}, right{{1, 0, 0}, {1, 0}}, left{{-1, 0, 0}, {1, 0}};
  const std::vector<glm::vec4> tangents = mikk_tangents(flat({bottom, right, top, bottom, top, left}));
  for (int i = 0; i < 3; ++i) expect_near(tangents[static_cast<std::size_t>(i)], {1, 0, 0, 1});
  for (int i = 3; i < 6; ++i) expect_near(tangents[static_cast<std::size_t>(i)], {-1, 0, 0, -1});
  // Both bitangents point in the direction of increasing v.
  for (const glm::vec4& t : tangents) EXPECT_GT((t.w * glm::cross(glm::vec3(0, 0, 1), glm::vec3(t))).y, 0.99f);
}

// Triangles that share only a vertex form two groups, and tangents are not averaged across the gap between them.
TEST(TangentSpace, AVertexAloneJoinsNothing) {
  const Corner middle{{0, 0, 0}, {0, 0}};
  const Corner a{{1, 0, 0}, {1, 0}}, b{{0, 1, 0}, {0, 1}};     // u along +x
  const Corner c{{-1, 0, 0}, {0, 1}}, d{{0, -1, 0}, {-1, 0}};  // u along +y, v along -x
  const std::vector<glm::vec4> tangents = mikk_tangents(flat({middle, a, b, middle, c, d}));
  expect_near(tangents[0], {1, 0, 0, 1});
  expect_near(tangents[3], {0, 1, 0, 1});
}

TEST(TangentSpace, TrianglesWithoutDirectionTakeANeighbours) {
  const Corner a{{0, 0, 0}, {0, 0}}, b{{1, 0, 0}, {1, 0}}, c{{0, 1, 0}, {0, 1}};
  const Corner d{{1, 1, 0}, {1, 0}};  // this vertex has the same u and v as b, so the triangle has no area in texture
                                      // space
  const Corner stray{{5, 5, 0}, {0, 0}}, stray2{{6, 5, 0}, {0, 0}}, stray3{{5, 6, 0}, {0, 0}};
  const std::vector<glm::vec4> tangents = mikk_tangents(flat({a, b, c, b, d, d, stray, stray2, stray3}));
  expect_near(tangents[3], {1, 0, 0, 1});  // the vertex b of the empty triangle
  for (const glm::vec4& t : tangents) {
    EXPECT_NEAR(glm::length(glm::vec3(t)), 1.0f, 1e-5f);
    EXPECT_NEAR(t.z, 0.0f, 1e-6f);
    EXPECT_EQ(std::abs(t.w), 1.0f);
  }
}

// The conformance model stores no tangents. The bumps of the model are steep, and its smooth normals lean with the
// bumps.
TEST(TangentSpace, OfTheConformanceModel) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA is not set";
  const TriangleMesh mesh = read_mesh(shared_data() + "/mesh/pc_NormalTangentTest.glb");
  int corners = 0;
  for (std::size_t first = 0; first < mesh.indices.size(); first += 3) {
    const auto at = [&](std::size_t k) { return mesh.indices[first + k]; };
    const glm::dvec3 e1 = mesh.positions[at(1)] - mesh.positions[at(0)],
                     e2 = mesh.positions[at(2)] - mesh.positions[at(0)];
    const glm::dvec2 d1 = mesh.uvs[at(1)] - mesh.uvs[at(0)], d2 = mesh.uvs[at(2)] - mesh.uvs[at(0)];
    const double area = d1.x * d2.y - d1.y * d2.x;
    if (std::abs(area) < 1e-9 || glm::length(glm::cross(e1, e2)) < 1e-12) continue;
    const glm::dvec3 along_u = (d2.y * e1 - d1.y * e2) / area, along_v = (d1.x * e2 - d2.x * e1) / area;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec4 t = mesh.tangents[at(k)];
      const glm::dvec3 n(mesh.normals[at(k)]), tangent(t);
      EXPECT_EQ(t.w, area > 0.0 ? 1.0f : -1.0f) << "triangle " << first / 3;
      EXPECT_GT(glm::dot(tangent, glm::normalize(along_u)), 0.5) << "triangle " << first / 3;
      EXPECT_GT(glm::dot(static_cast<double>(t.w) * glm::cross(n, tangent), glm::normalize(along_v)), 0.5)
          << "triangle " << first / 3;
      ++corners;
    }
  }
  EXPECT_GT(corners, 20000);
}

TEST(GltfMaterialTest, OfARealModel) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA is not set";
  const GltfMaterials model = read_gltf_materials(shared_data() + "/mesh/dutch_ship/dutch_ship_medium_1k.gltf");
  ASSERT_EQ(model.materials.size(), 3u);
  const TriangleMesh mesh = read_mesh(shared_data() + "/mesh/dutch_ship/dutch_ship_medium_1k.gltf");
  std::size_t triangles = 0;
  for (const MeshPart& part : mesh.parts) {
    ASSERT_LT(part.material_index, 3);
    EXPECT_EQ(part.material, model.materials[static_cast<std::size_t>(part.material_index)].name);
    triangles += part.index_count / 3;
  }
  EXPECT_EQ(triangles, 69162u);
}

}  // namespace
}  // namespace multum
