// SPDX-License-Identifier: Apache-2.0
// Tests the probe request and the manifest of inferred textures. Both must be the same after writing and reading, and
// messages must name every error.
#include <gtest/gtest.h>

#include "host/fields/inferred/inference_error.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/fields/inferred/matrix_json.h"
#include "host/fields/inferred/probe_request.h"
#include "tests/unit/fields/inferred/inference_assets.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_damage_is_refused;
using testing::expect_error;
using testing::expect_same;
using testing::Names;
using testing::TemporaryFolder;
using testing::unusual_mapping;
using testing::unusual_matrix;
using testing::with_value;

TEST(MatrixJsonTest, RowsAreRows) {
  glm::dmat4 m(0.0);
  m[3][0] = 5.0;  // a translation along x: last column, first row
  EXPECT_EQ(matrix_json(m).dump(), "[[0.0,0.0,0.0,5.0],[0.0,0.0,0.0,0.0],[0.0,0.0,0.0,0.0],[0.0,0.0,0.0,0.0]]");
  EXPECT_EQ(matrix_from_json(nlohmann::json::parse(matrix_json(unusual_matrix(0.1)).dump())), unusual_matrix(0.1));
  EXPECT_THROW(matrix_from_json(nlohmann::json::parse("[[1,2,3],[1,2,3],[1,2,3]]")), nlohmann::json::exception);
}

TEST(InferenceErrorTest, IsThatOfFramesElseThatOfLayers) {
  const TemporaryFolder folder;
  const auto error_of = [&](const std::string& report) {
    testing::write_bytes(folder / kInferenceReportName, report);
    return inference_error_sum(folder.path());
  };
  EXPECT_EQ(inference_error_sum(folder.path()), std::nullopt);
  EXPECT_EQ(error_of(R"({"frames": {"mse": 2.5, "pixels": 100}, "textures": []})"), 250.0);
  EXPECT_EQ(error_of(R"({"frames": {"mse": null, "pixels": 0}, "textures": []})"), 0.0);
  EXPECT_EQ(error_of(R"({"frames": null, "textures": [{"samples": [{"mse": 2, "pixels": 10}, {"mse": 0, "pixels": 0}]},
                                                      {"samples": [{"mse": 0.5, "pixels": 4}]}]})"),
            22.0);
  for (const char* other :
       {"", "[]", "{}", R"({"frames": {"mse": null, "pixels": 3}})", R"({"frames": {"mse": -1, "pixels": 3}})",
        R"({"frames": null, "textures": {"samples": 1}})"})
    EXPECT_EQ(error_of(other), std::nullopt) << other;
}

ProbeRequest unusual_request() {
  ProbeRequest request;
  request.geometry_file = "a folder/scène \"1\".glb";
  request.uv_set = 3;
  request.width = 641;
  request.height = 16384;
  request.supersampling = 8;
  request.view = "door\n2";
  request.world_to_clip = unusual_matrix(-3.0);
  request.object_to_world = {{"cup", unusual_matrix(0.5)}, {"Löffel", unusual_matrix(1e10)}};
  request.tasks = {{"cup", unusual_mapping(), 16.0f, false, "cup.filter", "cup key"},
                   {"floor", {}, 1.5f, true, "floor.filter", "floor key"}};
  request.tasks[1].mapping.width = 7;
  return request;
}

TEST(ProbeRequestTest, EveryFieldComesBack) {
  const TemporaryFolder folder;
  const ProbeRequest expected = unusual_request();
  write_probe_request(expected, folder / "r.json");
  const ProbeRequest found = read_probe_request(folder / "r.json");
  EXPECT_EQ(found.geometry_file, expected.geometry_file);
  EXPECT_EQ(found.uv_set, expected.uv_set);
  EXPECT_EQ(found.width, expected.width);
  EXPECT_EQ(found.height, expected.height);
  EXPECT_EQ(found.supersampling, expected.supersampling);
  EXPECT_EQ(found.view, expected.view);
  EXPECT_EQ(found.world_to_clip, expected.world_to_clip);
  EXPECT_EQ(found.object_to_world, expected.object_to_world);
  ASSERT_EQ(found.tasks.size(), expected.tasks.size());
  for (std::size_t i = 0; i < found.tasks.size(); ++i) {
    EXPECT_EQ(found.tasks[i].object, expected.tasks[i].object);
    expect_same(found.tasks[i].mapping, expected.tasks[i].mapping);
    EXPECT_EQ(found.tasks[i].anisotropy, expected.tasks[i].anisotropy);
    EXPECT_EQ(found.tasks[i].has_mips, expected.tasks[i].has_mips);
    EXPECT_EQ(found.tasks[i].output, expected.tasks[i].output);
    EXPECT_EQ(found.tasks[i].key, expected.tasks[i].key);
  }
  EXPECT_EQ(folder.names(), Names{"r.json"});
}

TEST(ProbeRequestTest, WhatIsMissingOrOfAnotherTypeIsRefused) {
  const TemporaryFolder folder;
  write_probe_request(unusual_request(), folder / "r.json");
  expect_damage_is_refused(folder / "r.json", "is not a probe request: ", {"objectToWorld"},
                           [](const std::string& path) { read_probe_request(path); });
}

TEST(ProbeRequestTest, WhatIsOutOfRangeIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "r.json";
  write_probe_request(unusual_request(), path);
  const auto refuse = [&](const std::string& place, const nlohmann::json& value, std::vector<std::string> parts) {
    parts.push_back(path + ": ");
    with_value(path, place, value, [&] { expect_error(ErrorCode::kInput, parts, [&] { read_probe_request(path); }); });
  };
  const auto accept = [&](const std::string& place, const nlohmann::json& value) {
    with_value(path, place, value, [&] { EXPECT_NO_THROW(read_probe_request(path)); });
  };
  refuse("/multumProbeRequest", 2, {"probe request", "version", "expected version 1"});
  for (const char* side : {"/width", "/height"})
    for (const int value : {0, -5, 16385}) refuse(side, value, {"1 to 16384"});
  for (const char* key : {"/width", "/height", "/uvSet", "/supersampling"})
    for (const nlohmann::json& value : {nlohmann::json(320.5), nlohmann::json(4294967297), nlohmann::json(1e30)})
      refuse(key, value, {key + 1, value.dump(), "expected an integer"});
  for (const int value : {0, -1, 9}) refuse("/supersampling", value, {"supersampling " + std::to_string(value)});
  accept("/supersampling", 1);
  for (const double value : {0.0, 0.999, -4.0, 16.01, 1e300}) refuse("/tasks/1/anisotropy", value, {"1 to 16"});
  accept("/tasks/1/anisotropy", 1);
  refuse("/tasks/0/mapping/width", 0, {"texture mapping", "0 x 16384"});
  refuse("/tasks/0/mapping/wrapS", "mirror", {"'mirror'", "clamp", "periodic"});
  expect_error(ErrorCode::kInput, {folder / "none.json", "cannot be read"},
               [&] { read_probe_request(folder / "none.json"); });
}

InferredManifest unusual_manifest() {
  InferredManifest manifest;
  manifest.geometry_file = "../scène.glb";
  manifest.geometry_hash = "0123456789abcdef";
  manifest.uv_set = 2;
  manifest.width = 33;
  manifest.height = 44;
  manifest.supersampling = 5;
  manifest.parameters = {"view", "light"};
  manifest.samples = {{"noon", {3, 0}, unusual_matrix(1.25), {{"cup", unusual_matrix(9.0)}}},
                      {"night", {2, 1}, unusual_matrix(-1.75), {}}};
  InferredLayer diffuse{"diffuse", {"a/0.exr", "a/1.exr"}}, other{"other", {"", "b/1.exr"}};
  manifest.objects = {{"the cup", "cup", {{}, unusual_mapping()}, {1, 0}, 2.5f, {diffuse, other}},
                      {"the floor", "floor", {{}}, {0, 0}, 1.0f, {}}};
  return manifest;
}

TEST(InferredManifestTest, EveryFieldComesBack) {
  const TemporaryFolder folder;
  const InferredManifest expected = unusual_manifest();
  write_inferred_manifest(expected, folder / kInferredManifestName);
  const InferredManifest found = read_inferred_manifest(folder / "inferred.json");
  EXPECT_EQ(found.geometry_file, expected.geometry_file);
  EXPECT_EQ(found.geometry_hash, expected.geometry_hash);
  EXPECT_EQ(found.uv_set, expected.uv_set);
  EXPECT_EQ(found.width, expected.width);
  EXPECT_EQ(found.height, expected.height);
  EXPECT_EQ(found.supersampling, expected.supersampling);
  EXPECT_EQ(found.parameters, expected.parameters);
  ASSERT_EQ(found.samples.size(), expected.samples.size());
  for (std::size_t i = 0; i < found.samples.size(); ++i) {
    EXPECT_EQ(found.samples[i].name, expected.samples[i].name);
    EXPECT_EQ(found.samples[i].at, expected.samples[i].at);
    EXPECT_EQ(found.samples[i].world_to_clip, expected.samples[i].world_to_clip);
    EXPECT_EQ(found.samples[i].object_to_world, expected.samples[i].object_to_world);
  }
  ASSERT_EQ(found.objects.size(), expected.objects.size());
  for (std::size_t i = 0; i < found.objects.size(); ++i) {
    const InferredObject &a = found.objects[i], &b = expected.objects[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.mesh, b.mesh);
    ASSERT_EQ(a.mappings.size(), b.mappings.size());
    for (std::size_t m = 0; m < a.mappings.size(); ++m) expect_same(a.mappings[m], b.mappings[m]);
    EXPECT_EQ(a.mapping_of_sample, b.mapping_of_sample);
    EXPECT_EQ(a.anisotropy, b.anisotropy);
    ASSERT_EQ(a.layers.size(), b.layers.size());
    for (std::size_t l = 0; l < a.layers.size(); ++l) {
      EXPECT_EQ(a.layers[l].name, b.layers[l].name);
      EXPECT_EQ(a.layers[l].textures, b.layers[l].textures);
    }
  }
  EXPECT_EQ(folder.names(), Names{"inferred.json"});
}

TEST(InferredManifestTest, WhatIsMissingOrOfAnotherTypeIsRefused) {
  const TemporaryFolder folder;
  write_inferred_manifest(unusual_manifest(), folder / "inferred.json");
  expect_damage_is_refused(folder / "inferred.json", "is not a manifest of inferred textures: ", {"objectToWorld"},
                           [](const std::string& path) { read_inferred_manifest(path); });
}

TEST(InferredManifestTest, WhatIsOutOfRangeIsRefused) {
  const TemporaryFolder folder;
  const std::string path = folder / "inferred.json";
  write_inferred_manifest(unusual_manifest(), path);
  const auto refuse = [&](const std::string& place, const nlohmann::json& value, std::vector<std::string> parts) {
    parts.push_back(path + ": ");
    with_value(path, place, value,
               [&] { expect_error(ErrorCode::kInput, parts, [&] { read_inferred_manifest(path); }); });
  };
  refuse("/multumInferredTextures", 2, {"manifest", "version", "expected version 1"});
  for (const char* side : {"/width", "/height"})
    for (const int value : {0, -5, 16385}) refuse(side, value, {"1 to 16384"});
  for (const char* key : {"/width", "/height", "/uvSet", "/supersampling"})
    for (const nlohmann::json& value : {nlohmann::json(320.5), nlohmann::json(4294967297), nlohmann::json(1e30)})
      refuse(key, value, {key + 1, value.dump(), "expected an integer"});
  for (const int value : {0, 9}) refuse("/supersampling", value, {"supersampling " + std::to_string(value)});
  refuse("/samples", nlohmann::json::array(), {"no samples"});
  refuse("/samples/1/at", {2}, {"'night'", "1 indices", "expected 2"});
  refuse("/samples/0/at", {2, 3, 4}, {"'noon'", "3 indices", "expected 2"});
  refuse("/parameters", {"view"}, {"'noon'", "2 indices", "expected 1"});
  refuse("/objects/0/layers/1/textures", {"b/0.exr"}, {"'other'", "'the cup'", "1 textures", "2 samples"});
  refuse("/objects/1/anisotropy", 17, {"1 to 16"});
  refuse("/objects/0/mappingOfSample", {0}, {"'the cup'", "mappingOfSample", "1 of 2 samples"});
  for (const int value : {-1, 2})
    refuse("/objects/0/mappingOfSample/1", value, {"'the cup'", "mapping " + std::to_string(value), "one of its 2"});
  refuse("/samples/1/at/0", 4294967298, {"at[0] is 4294967298", "expected an integer"});
  refuse("/objects/0/mappingOfSample/1", 0.5, {"mappingOfSample[1] is 0.5"});
  refuse("/objects/1/mappings/0/width", 4294967297, {"width is 4294967297"});
  refuse("/objects/1/mappings/0/visiblePixels", -1, {"visiblePixels is -1"});
  refuse("/objects/1/mappings", nlohmann::json::array(), {"'the floor'", "mapping 0"});
  refuse("/objects/1/mappings/0/height", 16385, {"texture mapping", "1 x 16385"});
  expect_error(ErrorCode::kInput, {folder / "none.json", "cannot be read"},
               [&] { read_inferred_manifest(folder / "none.json"); });
}

TEST(InferenceJsonTest, PlacesThatCannotBeWrittenAreRefused) {
  const TemporaryFolder folder;
  const std::vector<std::function<void(const std::string&)>> writers = {
      [](const std::string& path) { write_probe_request(unusual_request(), path); },
      [](const std::string& path) { write_inferred_manifest(unusual_manifest(), path); }};
  for (const auto& write : writers) {
    expect_error(ErrorCode::kEnvironment, {folder / "none/a.json", "does not exist"},
                 [&] { write(folder / "none/a.json"); });
    expect_error(ErrorCode::kUsage, {folder.path(), "is a folder"}, [&] { write(folder.path()); });
  }
  EXPECT_EQ(folder.names(), Names{});
}

}  // namespace
}  // namespace multum
