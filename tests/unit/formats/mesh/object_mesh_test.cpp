// SPDX-License-Identifier: Apache-2.0
// Tests objects of a scene file, which are found by name and read in their own space with the requested set of texture
// coordinates. Each error message names the file and the object.
#include "host/formats/mesh/object_mesh.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <glm/geometric.hpp>

#include "host/formats/image/files/exr_layers.h"
#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

void expect_refused(const std::string& path, int uv_set, std::vector<std::string> parts) {
  parts.push_back(path);
  expect_error(ErrorCode::kInput, parts, [&] { read_object_meshes(path, uv_set); });
}

TEST(ObjectMesh, NodesOfGltfAreObjectsInTheirOwnSpace) {
  const TemporaryFolder folder;
  GltfScene scene;
  scene.nodes = R"({"name":"group","translation":[0,0,5],"children":[1,2]},)"
                R"({"name":"left","mesh":0,"translation":[-1,0,0]},{"name":"right","mesh":0,"scale":[2,2,2]})";
  write_bytes(folder / "two.gltf", gltf_text(scene));
  const std::vector<ObjectMesh> objects = read_object_meshes(folder / "two.gltf", 0);
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].name, "left");
  EXPECT_EQ(objects[1].name, "right");
  const std::vector<glm::vec3> corners = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
  // Vertices are neither moved nor merged.
  for (const ObjectMesh& object : objects) EXPECT_EQ(object.positions, corners);
  EXPECT_EQ(objects[0].indices, (std::vector<std::uint32_t>{0, 1, 2}));
  EXPECT_EQ(glm::dvec3(objects[0].object_to_world * glm::dvec4(0.0, 0.0, 0.0, 1.0)), glm::dvec3(-1.0, 0.0, 5.0));
  EXPECT_EQ(glm::dvec3(objects[1].object_to_world * glm::dvec4(1.0, 0.0, 0.0, 1.0)), glm::dvec3(2.0, 0.0, 5.0));
}

TEST(ObjectMesh, VGrowsUpwardsAndSetsAreTold) {
  const TemporaryFolder folder;
  write_bytes(folder / "sets.gltf", gltf_text({}));  // set 0 is (0,0) (1,0) (0,1) in glTF, where v points down
  const std::vector<glm::vec2> set0 = {{0.0f, 1.0f}, {1.0f, 1.0f}, {0.0f, 0.0f}};
  const std::vector<glm::vec2> set1 = {{0.0f, 1.0f}, {3.0f, 1.0f}, {0.0f, -2.0f}};  // three times as large
  EXPECT_EQ(read_object_meshes(folder / "sets.gltf", 0)[0].uvs, set0);
  EXPECT_EQ(read_object_meshes(folder / "sets.gltf", 1)[0].uvs, set1);
  expect_refused(folder / "sets.gltf", 2, {"object 'thing'", "set 2", "TEXCOORD_2"});
  expect_refused(folder / "sets.gltf", -1, {"set is -1", "expected 0 to 7"});
  expect_refused(folder / "sets.gltf", 8, {"set is 8", "expected 0 to 7"});
}

TEST(ObjectMesh, ObjectsOfObjAreNamedAndPartsJoined) {
  const TemporaryFolder folder;
  // Normals differ at shared corners. Positions that are closer than 1e-5 must stay separate.
  write_bytes(folder / "parts.obj",
              "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 0.000001\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"
              "vn 0 0 1\nvn 0 1 0\n"
              "o quad\nf 1/1/1 2/2/1 3/3/1\nf 1/1/2 3/3/2 4/4/2\no near\nf 1/1/1 5/1/1 3/3/1\n");
  const std::vector<ObjectMesh> objects = read_object_meshes(folder / "parts.obj", 0);
  ASSERT_EQ(objects.size(), 2u);
  EXPECT_EQ(objects[0].name, "quad");
  EXPECT_EQ(objects[0].positions.size(), 4u);
  EXPECT_EQ(objects[0].indices, (std::vector<std::uint32_t>{0, 1, 2, 0, 2, 3}));
  EXPECT_EQ(objects[0].uvs[2], glm::vec2(1.0f, 1.0f));  // v points up, as in OBJ
  EXPECT_EQ(objects[0].object_to_world, glm::dmat4(1.0));
  EXPECT_EQ(objects[1].name, "near");
  EXPECT_EQ(objects[1].positions.size(), 3u);
}

TEST(ObjectMesh, RefusalsNameFileAndObject) {
  const TemporaryFolder folder;
  expect_refused(folder / "none.obj", 0, {"read"});
  write_bytes(folder / "bare.obj", "o thing\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  expect_refused(folder / "bare.obj", 0, {"object 'thing'", "texture coordinates", "set 0"});
  write_bytes(folder / "points.obj", "o thing\nv 0 0 0\nv 1 0 0\nvt 0 0\nl 1/1 2/1\n");
  expect_refused(folder / "points.obj", 0, {"triangles"});
  GltfScene twice;
  twice.nodes = R"({"children":[1,2]},{"name":"cup","mesh":0},{"name":"cup","mesh":0})";
  write_bytes(folder / "twice.gltf", gltf_text(twice));
  expect_refused(folder / "twice.gltf", 0, {"object 'cup'", "twice"});
  GltfScene range;
  range.last_index = 7;
  write_bytes(folder / "range.gltf", gltf_text(range));
  expect_refused(folder / "range.gltf", 0, {"range"});
  GltfScene infinite;
  infinite.positions[4] = HUGE_VALF;
  write_bytes(folder / "infinite.gltf", gltf_text(infinite));
  expect_refused(folder / "infinite.gltf", 0, {"object 'thing'", "vertex 1", "not finite"});
  GltfScene nan_uv;
  nan_uv.uvs[2] = NAN;
  write_bytes(folder / "nan_uv.gltf", gltf_text(nan_uv));
  expect_refused(folder / "nan_uv.gltf", 0, {"object 'thing'", "texture coordinate 1", "not finite"});
  GltfScene placed;
  placed.nodes = R"({"name":"thing","mesh":0,"scale":[1e30,1,1],"children":[1]},)"
                 R"({"name":"far","mesh":0,"scale":[1e30,1,1]})";
  write_bytes(folder / "placed.gltf", gltf_text(placed));
  EXPECT_EQ(read_object_meshes(folder / "placed.gltf", 0).size(), 2u);  // 1e60 is finite in double precision
  placed.nodes = R"({"name":"thing","mesh":0,"scale":[1e39,1,1]})";
  write_bytes(folder / "placed.gltf", gltf_text(placed));
  expect_refused(folder / "placed.gltf", 0, {"object 'thing'", "matrix", "finite"});
}

struct Hit {
  bool found = false;
  glm::dvec2 uv{0.0};
};

// Returns the texture coordinates at a point in object space. They come from the triangle around the point whose plane
// is nearest.
Hit uv_at(const ObjectMesh& object, const glm::dvec3& point) {
  Hit hit;
  double nearest = 1e-3;
  for (std::size_t i = 0; i < object.indices.size(); i += 3) {
    const glm::dvec3 a = object.positions[object.indices[i]], b = object.positions[object.indices[i + 1]],
                     c = object.positions[object.indices[i + 2]];
    const glm::dvec3 n = glm::cross(b - a, c - a);
    const double area2 = glm::dot(n, n);
    const double t = glm::dot(glm::cross(c - b, point - b), n) / area2;
    const double u = glm::dot(glm::cross(a - c, point - c), n) / area2;
    const double distance = std::abs(glm::dot(point - a, n)) / std::sqrt(area2);
    if (t < -1e-6 || u < -1e-6 || t + u > 1.0 + 1e-6 || distance > nearest) continue;
    nearest = distance;
    hit = {true, t * glm::dvec2(object.uvs[object.indices[i]]) + u * glm::dvec2(object.uvs[object.indices[i + 1]]) +
                     (1.0 - t - u) * glm::dvec2(object.uvs[object.indices[i + 2]])};
  }
  return hit;
}

// Compares with the renderer's own texture coordinates and depths, at pixels that an object covers completely. The pass
// is a mean over the pixel, so it mixes different places at self-occlusions and at the seam of the chart. The fraction
// of pixels with a difference above `tolerance` must be at most `elsewhere`.
void expect_uv_pass(const std::string& geometry, const std::string& mesh, const std::string& name, double tolerance,
                    double elsewhere) {
  const std::string folder = shared_field();
  const ExrLayers layers = read_exr_channels(folder + "/geom_v00.exr", {"UV.U", "UV.V", "Z"});
  const std::vector<float> coverage =
      read_cryptomatte_coverage(folder + "/geom_v00.exr", "CryptoObject", {name}).front();
  const DemoCamera camera = demo_camera(folder);
  std::size_t checked = 0, found = 0;
  for (const ObjectMesh& object : read_object_meshes(folder + "/" + geometry, 0)) {
    if (object.name != mesh) continue;
    const glm::dmat4 world_to_object = glm::inverse(object.object_to_world);
    for (std::size_t i = 0; i < coverage.size(); i += 7) {
      if (coverage[i] < 0.9999f) continue;
      const int x = static_cast<int>(i) % layers.width, y = static_cast<int>(i) / layers.width;
      const glm::dvec3 world = camera.world_at(x, y, static_cast<double>(layers.channels.at("Z")[i]));
      const Hit hit = uv_at(object, glm::dvec3(world_to_object * glm::dvec4(world, 1.0)));
      ++checked;
      if (!hit.found) continue;
      const glm::dvec2 expected(static_cast<double>(layers.channels.at("UV.U")[i]),
                                static_cast<double>(layers.channels.at("UV.V")[i]));
      found += glm::distance(hit.uv, expected) < tolerance ? 1 : 0;
    }
  }
  EXPECT_GT(checked, 100u);
  EXPECT_GE(static_cast<double>(found), (1.0 - elsewhere) * static_cast<double>(checked)) << geometry << ' ' << name;
}

TEST(ObjectMesh, TextureCoordinatesAreThoseOfTheRenderersUvPass) {
  if (shared_field().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA names no folder with field_demo1";
  expect_uv_pass("geometry.glb", "floor", "floor", 1e-4, 0.0);
  expect_uv_pass("geometry.obj", "floor_Mesh", "floor", 1e-4, 0.0);
  expect_uv_pass("geometry.glb", "vase", "vase", 5e-3, 0.1);  // placed by its node
  expect_uv_pass("geometry.obj", "vase_Mesh", "vase", 5e-3, 0.1);
}

}  // namespace
}  // namespace multum::testing
