// SPDX-License-Identifier: Apache-2.0
// Fuzzes models that `multum gltf` reads and writes, without decoding and fitting of images. The written model must be
// readable, and its buffer views must be in the right places.
#include <fmt/format.h>

#include "host/delivery/gltf/glb_layout.h"
#include "host/delivery/gltf/gltf_asset.h"
#include "host/delivery/gltf/gltf_rewrite.h"
#include "host/delivery/gltf/material_plan.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

constexpr const char* kNames[] = {"input.gltf", "input.glb"};

// The model has two materials that share one image with other users, an unknown extension, sparse accessors, several
// buffers, and a node with a skin. Only the beginning of each image is read.
constexpr char kModel[] =
    R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["ACME_x","KHR_texture_transform"],"materials":[)"
    R"({{"normalTexture":{{"index":0,"scale":2}},"occlusionTexture":{{"index":1}},"pbrMetallicRoughness":)"
    R"({{"roughnessFactor":0.5,"metallicRoughnessTexture":{{"index":1}}}},"extensions":{{"ACME_x":{{"a":[3,9]}}}}}},)"
    R"({{"normalTexture":{{"index":0,"extensions":{{"KHR_texture_transform":{{"rotation":1}}}}}},)"
    R"("pbrMetallicRoughness":{{"baseColorTexture":{{"index":1}}}}}}],"samplers":[{{"wrapS":33071}}],)"
    R"("textures":[{{"source":0,"sampler":0}},{{"source":1,"name":"orm"}}],)"
    R"("images":[{{"bufferView":0,"mimeType":"image/png"}},{{"bufferView":1,"mimeType":"image/png"}}],)"
    R"("scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0,"skin":0}}],"skins":[{{"joints":[0]}}],)"
    R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"material":1}}]}}],)"
    R"("accessors":[{{"componentType":5126,"count":2,"type":"SCALAR","sparse":{{"count":1,"indices":{{"bufferView":2,)"
    R"("componentType":5123}},"values":{{"bufferView":3}}}}}}],"bufferViews":[{{"buffer":0,"byteLength":24}},)"
    R"({{"buffer":0,"byteOffset":24,"byteLength":40}},{{"buffer":0,"byteOffset":64,"byteLength":4}},)"
    R"({{"buffer":1,"byteLength":4,"byteOffset":2,"byteStride":4}},{{"buffer":0,"byteOffset":60,"byteLength":8}}],)"
    R"("buffers":[{{{}"byteLength":70}},{{"byteLength":6,"uri":"data:;base64,AAECAwQF","name":"b"}}]}})";

std::string model_bytes() {
  const std::string png("\x89PNG\r\n\x1a\n", 8);
  return png + std::string(16, 'a') + png + std::string(32, 'b') + std::string("\1\0\0\0\2\0", 6);
}

std::string model_glb() {
  std::string text = fmt::format(kModel, ""), bytes = model_bytes();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  bytes.resize((bytes.size() + 3) / 4 * 4, '\0');
  const auto number = [](std::size_t value) {
    std::string made;
    for (int i = 0; i < 4; ++i) made += static_cast<char>((value >> (8 * i)) & 255);
    return made;
  };
  return "glTF" + number(2) + number(28 + text.size() + bytes.size()) + number(text.size()) + "JSON" + text +
         number(bytes.size()) + std::string("BIN\0", 4) + bytes;
}

void rewrite(const GltfAsset& asset, bool has_lobes) {
  const GltfPlan plan = plan_gltf(asset, !has_lobes);
  const std::string texture = fuzz::input_file("texture.ktx2", "bytes of a texture");
  std::vector<SourceTextures> textures;
  for (const LobeSource& source : plan.sources) {
    const EncodedTexture one{texture, "image/ktx2", 18};
    textures.push_back({one, one, source.is_anisotropic ? std::optional(one) : std::nullopt,
                        has_lobes ? std::optional(one) : std::nullopt, has_lobes ? std::optional(one) : std::nullopt});
  }
  RewrittenGltf rewritten = rewrite_gltf(asset, plan, textures);
  const std::string output = fuzz::scratch_folder() + "/output.glb";
  write_glb(asset, std::move(rewritten.json), rewritten.contents, output, nullptr);
  const GltfAsset again = read_gltf_asset(output);
  MULTUM_CHECK(again.array("materials").size() == asset.array("materials").size());
  for (const auto& [view, content] : rewritten.contents)
    MULTUM_CHECK(again.view_bytes(view).size() == content.byte_count);
  // Everything else that refers to the same bytes still finds them there.
  for (std::size_t view = 0; view < asset.array("bufferViews").size(); ++view) {
    const GltfJson& old = asset.array("bufferViews").at(view);
    if (rewritten.contents.contains(view) || !asset.buffers[asset.index(old, "buffer", "buffers")]) continue;
    MULTUM_CHECK(again.view_bytes(view) == asset.view_bytes(view));
  }
}

void convert(const std::string& path) {
  const GltfAsset asset = read_gltf_asset(path);
  for (const bool has_lobes : {false, true}) rewrite(asset, has_lobes);
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const std::string uri = R"("uri":"data:;base64,iVBORw0KGgphYWFhYWFhYWFhYWFhYWFhiVBORw0KGgpiYmJiYmJiYmJiYmJi)"
                          R"(YmJiYmJiYmJiYmJiYmJiYmJiYgEAAAACAA==",)";
  const std::vector<std::string> models = {fmt::format(kModel, uri), model_glb()};
  std::vector<std::string> seeds;
  for (const std::string& model : models) {
    const std::size_t kind = seeds.size();
    convert(fuzz::input_file(kNames[kind], model));  // a refused seed would be useless
    seeds.push_back(static_cast<char>(kind) + model);
  }
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 2);
  const std::string path = fuzz::input_file(kNames[input.kind], input.bytes);
  fuzz::may_refuse([&] {
    try {
      convert(path);
    } catch (const nlohmann::json::exception&) {  // for invalid JSON of glTF, convert_gltf() throws Error
    }
  });
  return 0;
}
