// SPDX-License-Identifier: Apache-2.0
// Tests models from unknown sources: invalid indices, URIs that do not name a file in the folder of the model, links
// and special files, and buffers with more bytes than declared.
#include "host/formats/mesh/gltf_document.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "host/delivery/gltf/gltf_asset.h"
#include "host/formats/mesh/gltf_check.h"
#include "host/formats/mesh/gltf_indices.h"
#include "host/formats/mesh/gltf_material.h"
#include "host/formats/mesh/object_mesh.h"
#include "tests/unit/fields/inference/animation_test_scene.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

using Json = nlohmann::json;

// Makes a model with one object of each kind and with every possible index. All indices are 0.
Json whole_model() {
  return Json::parse(R"({
    "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"children": [1], "mesh": 0, "skin": 0, "camera": 0, "extensions": {
      "EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 0}}, "KHR_lights_punctual": {"light": 0}}}, {}],
    "skins": [{"inverseBindMatrices": 0, "skeleton": 0, "joints": [0, 1]}], "cameras": [{}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 0, "material": 0,
      "targets": [{"POSITION": 0}], "extensions": {"KHR_draco_mesh_compression": {"bufferView": 0},
      "KHR_materials_variants": {"mappings": [{"material": 0}]}}}]}],
    "accessors": [{"bufferView": 0, "sparse": {"count": 1, "indices": {"bufferView": 0}, "values": {"bufferView": 0}}}],
    "bufferViews": [{"buffer": 0, "byteLength": 4, "extensions": {"EXT_meshopt_compression": {"buffer": 0},
      "KHR_meshopt_compression": {"buffer": 0}}}],
    "buffers": [{"byteLength": 4, "uri": "data:;base64,AAECAw=="}], "images": [{"bufferView": 0}], "samplers": [{}],
    "textures": [{"source": 0, "sampler": 0, "extensions": {"KHR_texture_basisu": {"source": 0},
      "EXT_texture_webp": {"source": 0}, "EXT_texture_avif": {"source": 0}, "MSFT_texture_dds": {"source": 0}}}],
    "materials": [{"normalTexture": {"index": 0}, "occlusionTexture": {"index": 0}, "emissiveTexture": {"index": 0},
      "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicRoughnessTexture": {"index": 0}},
      "extensions": {"KHR_materials_clearcoat": {"clearcoatNormalTexture": {"index": 0}}, "MULTUM_lobes": {"lobes": 0,
      "metallicRoughnessTexture": {"index": 0}}}}],
    "animations": [{"samplers": [{"input": 0, "output": 0}], "channels": [{"sampler": 0, "target": {"node": 0}}]}],
    "extensions": {"KHR_lights_punctual": {"lights": [{}]}, "MULTUM_lobes": {"lobes": [{"bufferView": 0}]}}
  })");
}

// Returns the positions of all numbers that are indices.
std::vector<std::string> index_places(const Json& model) {
  std::vector<std::string> places;
  const Json flat = model.flatten();
  for (const auto& [place, value] : flat.items()) {
    const bool is_index = value.is_number() && !place.ends_with("byteLength") && !place.ends_with("/count");
    if (is_index) places.push_back(place);
  }
  return places;
}

TEST(GltfDocumentTest, EveryIndexThatLeadsNowhereIsRefused) {
  const Json good = whole_model();
  EXPECT_NO_THROW(check_gltf_indices(good, "a.gltf"));
  const std::vector<std::string> places = index_places(good);
  EXPECT_EQ(places.size(), 44u);
  for (const std::string& place : places)
    for (const Json& wrong : {Json(2), Json(4294967296u), Json(-1), Json(0.5), Json("0"), Json(nullptr)}) {
      Json model = good;
      model[Json::json_pointer(place)] = wrong;
      expect_error(ErrorCode::kInput, {"a.gltf", place.substr(1) + " is " + wrong.dump(), "expected a number below"},
                   [&] { check_gltf_indices(model, "a.gltf"); });
      expect_error(ErrorCode::kInput, {"a.gltf"},
                   [&] { check_gltf_indices(nlohmann::ordered_json::parse(model.dump()), "a.gltf"); });
    }
}

TEST(GltfDocumentTest, ExtrasAndOtherExtensionsAreNotSearched) {
  Json model = whole_model();
  model["materials"][0]["extras"] = {{"bumpTexture", {{"index", 9}}}};
  model["materials"][0]["extensions"]["ACME_x"] = {{"aTexture", {{"index", 9}}}};
  model["meshes"][0]["extras"] = {{"mesh", 9}};
  EXPECT_NO_THROW(check_gltf_indices(model, "a.gltf"));
  EXPECT_NO_THROW(check_gltf_indices(Json::parse(R"({"asset":{"version":"1.0"},"scene":"one"})"), "a.gltf"));
}

class ModelFolderTest : public ::testing::Test {
 protected:
  ModelFolderTest() {
    std::filesystem::create_directory(folder_ / "model");
    write_bytes(folder_ / "secret", "secret");
    write_bytes(folder_ / "model/own.bin", "own bytes");
  }
  std::string write_model(const std::string& uri, std::uint64_t length = 4) {
    Json model = whole_model();
    model["buffers"][0] = {{"byteLength", length}, {"uri", uri}};
    write_bytes(model_, model.dump());
    return model_;
  }
  // Every reader of models refuses the URI.
  void expect_refused(const std::string& uri, std::vector<std::string> parts) {
    write_model(uri);
    expect_error(ErrorCode::kInput, parts, [&] { uri_path(model_, uri); });
    expect_error(ErrorCode::kInput, parts, [&] { check_gltf_file(model_); });
    expect_error(ErrorCode::kInput, parts, [&] { read_gltf_asset(model_); });
    expect_error(ErrorCode::kInput, parts, [&] { read_gltf_materials(model_); });
  }

  const TemporaryFolder folder_;
  const std::string model_ = folder_ / "model/a.gltf";
};

TEST_F(ModelFolderTest, UrisThatNameNoFileAreRefused) {
  expect_refused("", {model_, "empty URI"});
  expect_refused("%00", {model_, "NUL"});
  expect_refused("own.bin%00.png", {model_, "NUL"});
  expect_refused("..%2fsecret", {model_, "../secret", "not in its folder"});
  expect_refused("/dev/zero", {model_, "not in its folder"});
  expect_refused("file:///dev/zero", {model_});
  expect_refused(".", {"is a folder"});
}

TEST_F(ModelFolderTest, LinksAndSpecialFilesAreRefused) {
  std::filesystem::create_symlink("../secret", folder_ / "model/link.bin");
  std::filesystem::create_symlink("/dev/zero", folder_ / "model/zero.bin");
  std::filesystem::create_directory_symlink("..", folder_ / "model/up");
  ASSERT_EQ(::mkfifo((folder_ / "model/fifo.bin").c_str(), 0600), 0);
  expect_refused("link.bin", {"link.bin", "a link to", folder_ / "secret"});
  expect_refused("up/secret", {"up/secret", "a link to"});
  expect_refused("zero.bin", {"zero.bin", "a device"});
  expect_refused("fifo.bin", {"fifo.bin", "a FIFO"});
  std::filesystem::create_symlink("own.bin", folder_ / "model/own link.bin");
  EXPECT_EQ(read_gltf_asset(write_model("own%20link.bin")).buffers[0], "own ");
}

TEST_F(ModelFolderTest, NoMoreIsReadThanABufferSays) {
  // The file takes no disk space and is too large for any memory.
  std::filesystem::resize_file(folder_ / "model/own.bin", std::uintmax_t{1} << 43);
  EXPECT_EQ(read_gltf_asset(write_model("own.bin")).buffers[0], "own ");
  EXPECT_EQ(buffer_view_bytes(read_gltf_document(write_model("own.bin")), 0), "own ");
  expect_error(ErrorCode::kInput, {model_, "buffer 0", "4 GiB"},
               [&] { read_gltf_asset(write_model("own.bin", std::uint64_t{1} << 32)); });
  std::filesystem::resize_file(model_, std::uintmax_t{1} << 43);
  expect_error(ErrorCode::kInput, {model_, "4 GiB"}, [&] { read_gltf_asset(model_); });
}

TEST_F(ModelFolderTest, NulInTextsIsRefused) {
  write_bytes(model_, R"({"asset":{"version":"2.0"},"materials":[{"name":"a\u0000b"}]})");
  expect_error(ErrorCode::kInput, {model_, "NUL"}, [&] { read_gltf_document(model_); });
  expect_error(ErrorCode::kInput, {model_, "NUL"}, [&] { read_gltf_asset(model_); });
}

// Files that an OBJ file names are read only if they are in its folder or below it. No material library from elsewhere
// is read here.
TEST_F(ModelFolderTest, ObjFilesReadNoMaterialsFromElsewhere) {
  const std::string shape = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\no thing\nusemtl m\nf 1/1 2/2 3/3\n";
  std::filesystem::create_symlink("/dev/zero", folder_ / "model/zero.mtl");
  ASSERT_EQ(::mkfifo((folder_ / "model/fifo.mtl").c_str(), 0600), 0);
  for (const char* library : {"zero.mtl", "fifo.mtl", "../secret", "/dev/zero"}) {
    write_bytes(folder_ / "model/a.obj", std::string("mtllib ") + library + "\n" + shape);
    EXPECT_EQ(read_object_meshes(folder_ / "model/a.obj", 0).size(), 1u) << library;
  }
  std::filesystem::create_symlink("/dev/zero", folder_ / "zero.obj");
  for (const char* name : {"zero.obj", "model/fifo.mtl"})
    expect_error(ErrorCode::kInput, {folder_ / name, "expected a regular file"},
                 [&] { read_object_meshes(folder_ / name, 0); });
}

}  // namespace
}  // namespace multum::testing
