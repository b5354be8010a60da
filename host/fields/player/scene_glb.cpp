// SPDX-License-Identifier: Apache-2.0
#include "host/fields/player/scene_glb.h"

#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/json_file.h"

namespace multum {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF's buffers are little-endian");

constexpr std::uint32_t kMagic = 0x46546c67, kVersion = 2, kJsonChunk = 0x4e4f534a, kBinaryChunk = 0x004e4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125;

void append_word(std::string& text, std::size_t value) {
  const auto word = static_cast<std::uint32_t>(value);
  text.append(reinterpret_cast<const char*>(&word), sizeof(word));
}

void pad(std::string& text, char with) {
  while (text.size() % 4 != 0) text += with;
}

class GlbScene {
 public:
  explicit GlbScene(int uv_set) : uv_name_("TEXCOORD_" + std::to_string(uv_set)) {
    json_ = {{"asset", {{"version", "2.0"}, {"generator", "multum"}}}, {"scene", 0}};
    json_["scenes"] = json::array({{{"nodes", json::array()}}});
  }

  void add(const ObjectMesh& object) {
    // v grows downwards in glTF.
    std::vector<glm::vec2> uvs;
    for (const glm::vec2& uv : object.uvs) uvs.emplace_back(uv.x, 1.0f - uv.y);
    glm::vec3 low = object.positions.front(), high = low;
    for (const glm::vec3& position : object.positions) {
      low = glm::min(low, position);
      high = glm::max(high, position);
    }
    const int positions = accessor(object.positions, "VEC3", kFloat);
    json_["accessors"].back()["min"] = {low.x, low.y, low.z};
    json_["accessors"].back()["max"] = {high.x, high.y, high.z};
    const json attributes = {{"POSITION", positions}, {uv_name_, accessor(uvs, "VEC2", kFloat)}};
    const json primitive = {{"attributes", attributes}, {"indices", accessor(object.indices, "SCALAR", kUnsignedInt)}};
    json_["meshes"].push_back({{"name", object.name}, {"primitives", json::array({primitive})}});
    json matrix = json::array();
    for (int column = 0; column < 4; ++column)
      for (int row = 0; row < 4; ++row) matrix.push_back(object.object_to_world[column][row]);
    json_["scenes"][0]["nodes"].push_back(json_["nodes"].size());
    json_["nodes"].push_back({{"name", object.name}, {"mesh", json_["meshes"].size() - 1}, {"matrix", matrix}});
  }

  std::string file() {
    pad(binary_, '\0');
    json_["buffers"] = json::array({{{"byteLength", binary_.size()}}});
    std::string text = json_text(json_);
    pad(text, ' ');
    std::string bytes;
    append_word(bytes, kMagic);
    append_word(bytes, kVersion);
    append_word(bytes, 12 + 8 + text.size() + 8 + binary_.size());
    append_word(bytes, text.size());
    append_word(bytes, kJsonChunk);
    bytes += text;
    append_word(bytes, binary_.size());
    append_word(bytes, kBinaryChunk);
    return bytes + binary_;
  }

 private:
  template <typename Value>
  int accessor(const std::vector<Value>& values, const char* type, int component) {
    const std::size_t begin = binary_.size(), bytes = values.size() * sizeof(Value);
    binary_.append(reinterpret_cast<const char*>(values.data()), bytes);
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", begin}, {"byteLength", bytes}});
    json_["accessors"].push_back({{"bufferView", json_["bufferViews"].size() - 1},
                                  {"componentType", component},
                                  {"count", values.size()},
                                  {"type", type}});
    return static_cast<int>(json_["accessors"].size()) - 1;
  }

  std::string uv_name_, binary_;
  json json_;
};

}  // namespace

std::string scene_glb(const std::vector<ObjectMesh>& objects, int uv_set) {
  GlbScene scene(uv_set);
  for (const ObjectMesh& object : objects) scene.add(object);
  return scene.file();
}

}  // namespace multum
