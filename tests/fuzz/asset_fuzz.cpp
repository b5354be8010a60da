// SPDX-License-Identifier: Apache-2.0
// Fuzzes readers of smaller files and texts: filter matrices, probe requests, the list of inferred textures, settings
// in headers, results of test cases, and "FILE:CHANNEL" arguments.
#include "host/fields/inferred/filter_matrix.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/fields/inferred/probe_request.h"
#include "host/formats/image/material_maps.h"
#include "host/formats/image/normals/reading_settings.h"
#include "host/lab/reference/case_table.h"
#include "tests/fuzz/fuzz.h"

namespace multum {
namespace {

FilterMatrix small_matrix() {
  FilterMatrix matrix;
  matrix.width = 4;
  matrix.height = 3;
  matrix.texture_width = 4;
  matrix.texture_height = 2;
  matrix.provenance = {"multum-view", "osmesa", "front", "wall", "", "", "key"};
  matrix.pixels = {0, 5, 11};
  matrix.coverage = {1.0f, 0.5f, 0.25f};
  matrix.row_begin = {0, 1, 3, 4};
  matrix.columns = {0, 1, 9, 10};
  matrix.weights = {1.0f, 0.5f, 0.5f, 1.0f};
  return matrix;
}

TextureMapping small_mapping() {
  TextureMapping mapping;
  mapping.width = 16;
  mapping.height = 8;
  return mapping;
}

ProbeRequest small_request() {
  ProbeRequest request;
  request.geometry_file = "scene.glb";
  request.width = request.height = 4;
  request.view = "front";
  request.object_to_world["wall"] = glm::dmat4(1.0);
  request.tasks.push_back({"wall", small_mapping(), 1.0f, true, "wall.fmx", "key"});
  return request;
}

InferredManifest small_manifest() {
  InferredManifest manifest;
  manifest.geometry_file = "scene.glb";
  manifest.geometry_hash = std::string(64, 'c');
  manifest.width = manifest.height = 4;
  manifest.parameters = {"view"};
  manifest.samples.push_back({"v0", {0}, glm::dmat4(1.0), {{"wall", glm::dmat4(1.0)}}});
  manifest.objects.push_back({"wall", "wall", {small_mapping()}, {0}, 1.0f, {{"diffuse", {"wall_0.exr"}}}});
  return manifest;
}

}  // namespace

std::vector<std::string> fuzz::seeds() {
  const std::string path = scratch_folder() + "/seed";
  std::vector<std::string> seeds;
  const auto add = [&](char kind) { seeds.push_back(kind + file_bytes(path)); };
  write_filter_matrix(small_matrix(), path);
  add('\0');
  write_probe_request(small_request(), path);
  add('\1');
  write_inferred_manifest(small_manifest(), path);
  add('\2');
  seeds.push_back(
      "\3{\"bump_format\":\"normal\",\"green\":\"down\",\"signed\":true,\"height_scale\":2.5,"
      "\"normal_scale\":0.5,\"wrap\":[\"clamp\",\"mirror\"],\"fixnan\":\"box3\"}");
  NumericalRun run;
  seeds.push_back("\4" + case_json(run));
  seeds.push_back("\5rough.png:G");
  return seeds;
}

}  // namespace multum

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace multum;
  const auto input = fuzz::split(data, size, 6);
  const std::string text(input.bytes);
  fuzz::may_refuse([&] {
    switch (input.kind) {
      case 0: {
        const std::string path = fuzz::input_file("input.fmx", text);
        fuzz::may_refuse([&] { filter_matrix_key(path); });
        const FilterMatrix matrix = read_filter_matrix(path);
        // Checks the properties of a matrix that other code relies on without checking them.
        MULTUM_CHECK(matrix.row_begin.size() == matrix.row_count() + 1 &&
                     matrix.row_begin.back() == matrix.columns.size());
        for (const std::uint32_t column : matrix.columns)
          MULTUM_CHECK(column < static_cast<std::uint32_t>(matrix.layout().texel_count));
        for (const std::uint32_t pixel : matrix.pixels)
          MULTUM_CHECK(pixel < static_cast<std::uint32_t>(matrix.width * matrix.height));
        break;
      }
      case 1: read_probe_request(fuzz::input_file("input.json", text)); break;
      case 2: read_inferred_manifest(fuzz::input_file("input.json", text)); break;
      case 3: parse_reading_settings(text); break;
      case 4: parse_case_json(text, "cases.json"); break;
      default: parse_channel_file(text);
    }
  });
  return 0;
}
