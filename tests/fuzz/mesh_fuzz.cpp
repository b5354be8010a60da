// SPDX-License-Identifier: Apache-2.0
// Meshes, whole and by object, and the materials of glTF. assimp reads them in this process: multum-view's, which the
// service runs as a child.
#include <fmt/format.h>

#include <cmath>
#include <cstring>

#include "host/mesh/gltf_material.h"
#include "host/mesh/mesh.h"
#include "host/mesh/object_mesh.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

constexpr const char* kNames[] = {"input.obj", "input.gltf", "input.glb"};

constexpr char kObj[] =
    "o thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 1\n"
    "f 1/1/1 2/2/1 3/3/1 4/4/1\ng more\nusemtl brick\nf 1/1 2/2 3/3\nf -1/-1 -2/-2 -3/-3\n";

// A triangle: positions, coordinates, indices.
std::string buffer() {
  const float numbers[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
  const std::uint16_t indices[] = {0, 1, 2, 0};
  std::string bytes(reinterpret_cast<const char*>(numbers), sizeof(numbers));
  return bytes.append(reinterpret_cast<const char*>(indices), sizeof(indices));
}

std::string base64(const std::string& bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i + 2 < bytes.size(); i += 3) {
    unsigned triple = 0;
    for (std::size_t k = 0; k < 3; ++k) triple = triple << 8 | static_cast<unsigned char>(bytes[i + k]);
    for (int shift = 18; shift >= 0; shift -= 6) text += kDigits[triple >> shift & 63];
  }
  return text;
}

std::string gltf(const std::string& uri) {
  return fmt::format(
      R"({{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"name":"thing","mesh":0,)"
      R"("translation":[0,0,1]}}],"meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"TEXCOORD_0":1}},)"
      R"("indices":2,"material":0}}]}}],"materials":[{{"name":"brick","normalTexture":{{"index":0,"scale":0.5}},)"
      R"("pbrMetallicRoughness":{{"roughnessFactor":0.5}}}}],"textures":[{{"source":0}}],"images":[{{"uri":"n.png"}}],)"
      R"("accessors":[{{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},)"
      R"({{"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"}},)"
      R"({{"bufferView":2,"componentType":5123,"count":3,"type":"SCALAR"}}],)"
      R"("bufferViews":[{{"buffer":0,"byteOffset":0,"byteLength":36}},{{"buffer":0,"byteOffset":36,"byteLength":24}},)"
      R"({{"buffer":0,"byteOffset":60,"byteLength":6}}],"buffers":[{{{}"byteLength":66}}]}})",
      uri);
}

std::string chunk(const char* type, std::string data, char fill) {
  while (data.size() % 4 != 0) data += fill;
  const auto size = static_cast<std::uint32_t>(data.size());
  return std::string(reinterpret_cast<const char*>(&size), sizeof(size)) + std::string(type, 4) + data;
}

std::string glb() {
  const std::string chunks = chunk("JSON", gltf(""), ' ') + chunk("BIN\0", buffer(), '\0');
  const std::uint32_t head[2] = {2, static_cast<std::uint32_t>(12 + chunks.size())};
  return "glTF" + std::string(reinterpret_cast<const char*>(head), sizeof(head)) + chunks;
}

void check(const TriangleMesh& mesh) {
  MULTUM_CHECK(mesh.normals.size() == mesh.positions.size() && mesh.tangents.size() == mesh.positions.size());
  MULTUM_CHECK(mesh.uvs.size() == mesh.positions.size() && mesh.indices.size() % 3 == 0);
  for (const std::uint32_t index : mesh.indices) MULTUM_CHECK(index < mesh.positions.size());
  for (const glm::vec3& normal : mesh.normals) MULTUM_CHECK(std::isfinite(normal.x + normal.y + normal.z));
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const std::string uri = R"("uri":"data:application/octet-stream;base64,)" + base64(buffer()) + R"(",)";
  return {std::string(1, '\0') + kObj, "\1" + gltf(uri), "\2" + glb()};
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 3);
  const std::string path = fuzz::input_file(kNames[input.kind], input.bytes);
  fuzz::may_refuse([&] { check(read_mesh(path)); });
  fuzz::may_refuse([&] {
    for (const ObjectMesh& mesh : read_object_meshes(path, 0))
      for (const std::uint32_t index : mesh.indices) MULTUM_CHECK(index < mesh.positions.size());
  });
  if (input.kind > 0) fuzz::may_refuse([&] { read_gltf_materials(path); });
  return 0;
}
