// SPDX-License-Identifier: Apache-2.0
// Fuzzes the glTF mesh readers of multum-decode, which read the whole mesh or single objects. Also fuzzes the client
// that reads multum-decode's answers, and the reader of materials. OBJ has a fuzzer of its own, because assimp fills 32
// MiB for each file, which takes ten times as long as everything here.
#include <fmt/format.h>

#include <algorithm>

#include "host/formats/decoder/libraries/mesh_decoder.h"
#include "host/formats/mesh/gltf_material.h"
#include "host/foundation/base/base64.h"
#include "tests/fuzz/mesh_checks.h"

namespace multum {
namespace {

// Returns the positions, texture coordinates and indices of a triangle.
std::string buffer() {
  const float numbers[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1};
  const std::uint16_t indices[] = {0, 1, 2, 0};
  std::string bytes(reinterpret_cast<const char*>(numbers), sizeof(numbers));
  return bytes.append(reinterpret_cast<const char*>(indices), sizeof(indices));
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

void read_materials(const std::string& path) { read_gltf_materials(path); }

// Reads an answer and the arrays that follow it. If the bytes end early, the rest of the arrays is filled with zeros.
template <typename Meshes>
void take(std::string_view bytes) {
  const AskedFile asked = {"fuzz.glb", "assimp", 1u << 20};
  MessageReader in(bytes);
  try {
    auto meshes = parse_mesh_answer<Meshes>(asked, in);
    std::vector<std::byte> memory(array_bytes(meshes));
    const std::string_view rest = in.rest();
    std::copy_n(reinterpret_cast<const std::byte*>(rest.data()), std::min(rest.size(), memory.size()), memory.data());
    take_arrays(asked, memory.data(), meshes);
    fuzz::check(meshes);
  } catch (const std::out_of_range&) {  // parse_answer() refuses such an answer
  }
}

struct Reader {
  const char* name;  // of the file
  void (*read)(const std::string& path);
};
constexpr Reader kReaders[] = {{"input.gltf", fuzz::read_whole},   {"input.glb", fuzz::read_whole},
                               {"input.gltf", fuzz::read_objects}, {"input.glb", fuzz::read_objects},
                               {"input.gltf", read_materials},     {"input.glb", read_materials}};
constexpr unsigned kReaderCount = std::size(kReaders), kAnswerKinds = 2;

// Returns the answer of multum-decode without its first byte, and the bytes that multum-decode writes into shared
// memory.
std::string answer_of(DecodingRequest kind) {
  constexpr std::size_t kMemory = 2048;  // in bytes, which is more than the arrays of the seed need
  MeshDecoder decoder;
  SharedMemory memory;
  std::string answer =
      decoder.answer(open_mesh_request(kind, fuzz::input_file("seed.glb", glb()), 0), memory).substr(1);
  const std::byte* const arrays = memory.reserve(kMemory);
  decoder.answer(read_mesh_request(), memory);
  return answer.append(reinterpret_cast<const char*>(arrays), kMemory);
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const std::string uri = R"("uri":"data:application/octet-stream;base64,)" + encode_base64(buffer()) + R"(",)";
  std::vector<std::string> seeds;
  for (const Reader& reader : kReaders) {
    const std::string_view name = reader.name;
    seeds.push_back(static_cast<char>(seeds.size()) + (name.ends_with("glb") ? glb() : gltf(uri)));
  }
  for (const DecodingRequest kind : {DecodingRequest::kOpenMesh, DecodingRequest::kOpenObjects})
    seeds.push_back(static_cast<char>(seeds.size()) + answer_of(kind));
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, kReaderCount + kAnswerKinds);
  fuzz::may_refuse([&] {
    if (input.kind == kReaderCount) return take<TriangleMesh>(input.bytes);
    if (input.kind > kReaderCount) return take<ObjectMeshes>(input.bytes);
    const Reader& reader = kReaders[input.kind];
    reader.read(fuzz::input_file(reader.name, input.bytes));
  });
  return 0;
}
