// SPDX-License-Identifier: Apache-2.0
// See animation_test_scene.h.
#include "tests/unit/fields/inference/animation_test_scene.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <glm/matrix.hpp>
#include <nlohmann/json.hpp>

#include "host/foundation/base/base64.h"
#include "tests/fixtures/shared_data.h"
#include "tests/unit/formats/image/image_test_files.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

template <typename Values>
std::string bytes_of(const Values& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(values[0])};
}

glm::dmat4 matrix_of(const nlohmann::json& rows) {
  glm::dmat4 m;
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column)
      m[column][row] = rows[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)].get<double>();
  return m;
}

nlohmann::json shifted(double x, double y, double z) {
  return {{1, 0, 0, x}, {0, 1, 0, y}, {0, 0, 1, z}, {0, 0, 0, 1}};
}

nlohmann::json sample_json(int view, int param, bool moves) {
  char name[16];
  std::snprintf(name, sizeof name, "v%02d_p%02d", view, param);
  nlohmann::json sample = {{"view", view}, {"param", param}, {"name", name}};
  sample["world_to_camera"] = shifted(-0.25 + 0.125 * view, -0.25, -2.0);
  // The near plane is at 0.1 and the far plane at 10. At a distance of 2 the picture extends 1/8 to each side of the
  // centre.
  sample["projection"] = {{16, 0, 0, 0}, {0, 16, 0, 0}, {0, 0, -1.02020202, -0.202020202}, {0, 0, -1, 0}};
  if (moves) sample["object_to_world"]["thing"] = shifted(0.0, 0.0, 0.125 * param);
  if (!moves) sample["light_swing_deg"] = 22.0 * param;
  return sample;
}

}  // namespace

std::string gltf_text(const GltfScene& scene) {
  std::array<float, 6> tripled = scene.uvs;
  for (float& value : tripled) value *= 3.0f;
  const std::array<std::uint16_t, 6> indices = {0, 1, scene.last_index, 0, 0, 0};  // rgb_planes needs whole triangles
  const std::string buffer = bytes_of(scene.positions) + bytes_of(scene.uvs) + bytes_of(tripled) + bytes_of(indices);
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[)" + scene.nodes +
         R"(],"meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1,"TEXCOORD_1":2},"indices":3}]}],)"
         R"("buffers":[{"byteLength":96,"uri":"data:application/octet-stream;base64,)" +
         encode_base64(buffer) +
         R"("}],"bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":24},)"
         R"({"buffer":0,"byteOffset":60,"byteLength":24},{"buffer":0,"byteOffset":84,"byteLength":12}],"accessors":[)"
         R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
         R"({"bufferView":1,"componentType":5126,"count":3,"type":"VEC2"},)"
         R"({"bufferView":2,"componentType":5126,"count":3,"type":"VEC2"},)"
         R"({"bufferView":3,"componentType":5123,"count":3,"type":"SCALAR"}]})";
}

std::string gltf_bomb() {
  const std::string accessor =
      R"({"componentType":5126,"count":200000000,"type":"VEC3","min":[0,0,0],"max":[1,1,1],"sparse":{"count":1,)"
      R"("indices":{"bufferView":0,"componentType":5123},"values":{"bufferView":1}}})";
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":0}}]}],)"
         R"("buffers":[{"byteLength":16,"uri":"data:application/octet-stream;base64,AAAAAAAAgD8AAIA/AACAPw=="}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":2},{"buffer":0,"byteOffset":4,"byteLength":12}],"accessors":[)" +
         accessor + "]}";
}

void write_exr(const std::string& path, int width, int height, const std::vector<ExrPart>& parts) {
  std::vector<OIIO::ImageSpec> specs;
  for (const ExrPart& part : parts) {
    OIIO::ImageSpec spec(width, height, static_cast<int>(part.channels.size()), OIIO::TypeDesc(part.type));
    spec.channelnames = part.channels;
    spec.attribute("compression", "zip");
    if (parts.size() > 1) spec.attribute("oiio:subimagename", part.name);
    for (const auto& [key, value] : part.attributes) spec.attribute(key, value);
    specs.push_back(spec);
  }
  const auto output = OIIO::ImageOutput::create(path);
  ASSERT_TRUE(output) << OIIO::geterror();
  const bool is_open = parts.size() == 1 ? output->open(path, specs[0])
                                         : output->open(path, static_cast<int>(specs.size()), specs.data());
  ASSERT_TRUE(is_open) << output->geterror();
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (p > 0) {
      ASSERT_TRUE(output->open(path, specs[p], OIIO::ImageOutput::AppendSubimage)) << output->geterror();
    }
    const std::size_t channel_count = parts[p].planes.size();
    std::vector<float> values(parts[p].planes[0].size() * channel_count);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = parts[p].planes[i % channel_count][i / channel_count];
    ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, values.data())) << output->geterror();
  }
  ASSERT_TRUE(output->close()) << output->geterror();
}

std::string shared_field() {
  if (shared_data().empty()) return "";
  const std::string field = shared_data() + "/field_demo1";
  return std::filesystem::exists(field + "/scene.json") ? field : "";
}

glm::dvec3 DemoCamera::world_at(int x, int y, double depth) const {
  const double ndc_x = 2.0 * (x + 0.5) / width - 1.0, ndc_y = 1.0 - 2.0 * (y + 0.5) / height;
  const glm::dvec4 camera(ndc_x * depth / projection[0][0], ndc_y * depth / projection[1][1], -depth, 1.0);
  return glm::dvec3(glm::inverse(world_to_camera) * camera);
}

DemoCamera demo_camera(const std::string& folder) {
  const nlohmann::json scene = nlohmann::json::parse(std::ifstream(folder + "/scene.json"));
  const nlohmann::json& sample = scene["samples"][0];
  return {matrix_of(sample["world_to_camera"]), matrix_of(sample["projection"]), scene["width"].get<int>(),
          scene["height"].get<int>()};
}

void write_demo_folder(const std::string& folder, bool moves) {
  constexpr int kWidth = 4, kHeight = 3;
  const std::vector<float> plane(kWidth * kHeight, 0.5f);
  nlohmann::json scene = {
      {"mode", moves ? "demo2" : "demo1"}, {"width", kWidth}, {"height", kHeight}, {"views", 2}, {"params", 2}};
  scene["objects"]["thing"] = {{"triangles", 1}, {"object_to_world", shifted(0.0, 0.0, 0.0)}};
  for (int view = 0; view < 2; ++view) {
    for (int param = 0; param < 2; ++param) {
      const nlohmann::json sample = sample_json(view, param, moves);
      scene["samples"].push_back(sample);
      const std::string name = sample["name"];
      ExrPart radiance{"", {"R", "G", "B"}, {}, {}};
      for (const char* pass : {"diffuse", "glossy", "transmission"})
        for (const char* c : {".R", ".G", ".B"}) radiance.channels.push_back(std::string(pass) + c);
      radiance.planes.assign(radiance.channels.size(), plane);
      write_exr(folder + "/rad_" + name + ".exr", kWidth, kHeight, {radiance});
      if (moves) {
        TestImage index{.width = kWidth, .height = kHeight, .channels = 1};
        index.values.assign(plane.size(), 1.0f / 255.0f);
        write_test_image(folder + "/id_" + name + ".png", index);
      }
    }
    ExrPart geometry{"", {"Z", "CryptoObject00.r", "CryptoObject00.g", "CryptoObject00.b", "CryptoObject00.a"}, {}, {}};
    geometry.planes = {std::vector<float>(plane.size(), 2.0f),
                       std::vector<float>(plane.size(), std::bit_cast<float>(0x3f400000u)),
                       std::vector<float>(12, 1.0f), std::vector<float>(12, 0.0f), std::vector<float>(12, 0.0f)};
    geometry.attributes = {{"cryptomatte/1234567/name", "ViewLayer.CryptoObject"},
                           {"cryptomatte/1234567/hash", "MurmurHash3_32"},
                           {"cryptomatte/1234567/conversion", "uint32_to_float32"},
                           {"cryptomatte/1234567/manifest", R"({"thing":"3f400000"})"}};
    write_exr(folder + "/geom_v0" + std::to_string(view) + ".exr", kWidth, kHeight, {geometry});
  }
  write_bytes(folder + "/scene.json", scene.dump(1));
  write_bytes(folder + "/geometry.gltf", gltf_text({}));
}

}  // namespace multum::testing
