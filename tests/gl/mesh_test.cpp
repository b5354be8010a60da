// SPDX-License-Identifier: Apache-2.0
// Tests the reading of meshes: tangent frames, conventions, and error messages that name the file and the fault.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include <glm/geometric.hpp>

#include "host/formats/mesh/mesh.h"
#include "host/foundation/base/base64.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "tests/fixtures/shared_data.h"

namespace multum {
namespace {

using testing::shared_data;

std::string temporary_file(const std::string& name, const std::string& text) {
  const std::string path = ::testing::TempDir() + "multum_mesh_" + name;
  write_text_file(path, text);
  return path;
}

std::string refusal(const std::string& path) {
  try {
    read_mesh(path);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::kInput);
    EXPECT_EQ(std::string(error.what()).find(path), 0u) << error.what();
    return error.what();
  }
  ADD_FAILURE() << path << " was read";
  return "";
}

void expect_good_frames(const TriangleMesh& mesh) {
  ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
  ASSERT_EQ(mesh.tangents.size(), mesh.positions.size());
  ASSERT_EQ(mesh.uvs.size(), mesh.positions.size());
  ASSERT_EQ(mesh.indices.size() % 3, 0u);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    ASSERT_NEAR(glm::length(mesh.normals[i]), 1.0f, 1e-5f);
    ASSERT_NEAR(glm::length(glm::vec3(mesh.tangents[i])), 1.0f, 1e-5f);
    ASSERT_NEAR(glm::dot(glm::vec3(mesh.tangents[i]), mesh.normals[i]), 0.0f, 1e-4f);
    ASSERT_EQ(std::abs(mesh.tangents[i].w), 1.0f);
  }
  for (const std::uint32_t index : mesh.indices) ASSERT_LT(index, mesh.positions.size());
}

TEST(Mesh, TangentsFollowTheTextureCoordinates) {
  const std::string head = "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\n";
  const TriangleMesh plain =
      read_mesh(temporary_file("plain.obj", head + "vt 0 0\nvt 1 0\nvt 1 1\nf 1/1/1 2/2/1 3/3/1\n"));
  expect_good_frames(plain);
  EXPECT_NEAR(plain.tangents[0].x, 1.0f, 1e-5f);
  EXPECT_EQ(plain.tangents[0].w, 1.0f);
  const TriangleMesh mirrored =
      read_mesh(temporary_file("mirrored.obj", head + "vt 0 0\nvt -1 0\nvt -1 1\nf 1/1/1 2/2/1 3/3/1\n"));
  EXPECT_NEAR(mirrored.tangents[0].x, -1.0f, 1e-5f);
  EXPECT_EQ(mirrored.tangents[0].w, -1.0f);
  EXPECT_EQ(mirrored.uvs[2], glm::vec2(-1.0f, 1.0f));  // v grows upwards, as in OBJ
}

TEST(Mesh, PlaneHasTheFrameThatShadersExpect) {
  const TriangleMesh plane = make_plane(2.0f);
  expect_good_frames(plane);
  const glm::vec3 bitangent = plane.tangents[0].w * glm::cross(plane.normals[0], glm::vec3(plane.tangents[0]));
  EXPECT_EQ(bitangent, glm::vec3(0.0f, 1.0f, 0.0f));
}

TEST(Mesh, RefusesWhatCannotCarryAMap) {
  EXPECT_NE(refusal(temporary_file("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).find("texture coordinates"),
            std::string::npos);
  EXPECT_NE(refusal(::testing::TempDir() + "multum_mesh_none.obj"), "");
  EXPECT_NE(refusal(::testing::TempDir() + "multum_mesh_none.glb").find("cannot be read"), std::string::npos);
  EXPECT_NE(refusal(temporary_file("cut.glb", "glTF")).find("GLB"), std::string::npos);
  EXPECT_NE(refusal(temporary_file("bad.gltf", "{\"asset\": ")).find("JSON"), std::string::npos);
  const std::string draco = "{\"asset\":{\"version\":\"2.0\"},\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]}";
  EXPECT_NE(refusal(temporary_file("draco.gltf", draco)).find("KHR_draco_mesh_compression"), std::string::npos);
}

/// Returns glTF with an inline buffer and two triangles. The first is a right triangle, and the last index of the
/// second is `index`.
std::string two_triangles(char index) {
  const char indices[12] = {0, 0, 1, 0, 2, 0, 0, 0, 1, 0, index, 0};
  // The positions (0,0,0) (1,0,0) (0,1,0) and the texture coordinates (0,0) (1,0) (0,1) take 60 bytes.
  const std::string base64 =
      "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAA"
      "AIA/AAAAAAAAAAAAAIA/" +
      encode_base64({indices, sizeof(indices)});
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"indices":2}]}],)"
         R"("buffers":[{"byteLength":72,"uri":"data:application/octet-stream;base64,)" +
         base64 +
         R"("}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},)"
         R"({"buffer":0,"byteOffset":60,"byteLength":12}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
         R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},)"
         R"({"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}]})";
}

TEST(Mesh, RefusesIndicesOutOfRange) {
  EXPECT_EQ(read_mesh(temporary_file("good.gltf", two_triangles(2))).indices.size(), 6u);
  EXPECT_NE(refusal(temporary_file("range.gltf", two_triangles(7))).find("range"), std::string::npos);
}

TEST(Mesh, ReadsRealMeshes) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA is not set";
  for (const char* name : {"spot.obj", "mx_teapot.obj", "pc_NormalTangentTest.glb"}) {
    SCOPED_TRACE(name);
    expect_good_frames(read_mesh(shared_data() + "/mesh/" + name));
  }
}

TEST(Mesh, RefusesRealBadMeshes) {
  if (shared_data().empty()) GTEST_SKIP() << "MULTUM_SHARED_DATA is not set";
  const std::string folder = shared_data() + "/bad/mesh/";
  EXPECT_NE(refusal(folder + "pc_carbon-sphere_draco.glb").find("KHR_draco_mesh_compression"), std::string::npos);
  refusal(folder + "number_formats.obj");
  refusal(folder + "AllIndicesOutOfRange.gltf");
}

}  // namespace
}  // namespace multum
