// SPDX-License-Identifier: Apache-2.0
// Tests the blocks of samples of a field, and the description of a packed field.
#include "host/fields/codec/field_description.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <functional>
#include <set>
#include <string>
#include <vector>

#include "host/fields/codec/byte_writer.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

// Makes a field of 5 views by 3 lights, whose mapping changes at view 3.
InferredManifest field_of_15() {
  InferredManifest field;
  field.geometry_file = "scene.obj";
  field.geometry_hash = "0";
  field.width = 20;
  field.height = 10;
  field.supersampling = 2;
  field.parameters = {"view", "light"};
  InferredObject object;
  object.name = object.mesh = "vase";
  object.mappings.resize(2);
  object.mappings[0].width = 7;
  object.mappings[0].linear = {{0.1, 2.0}, {-1.0 / 3.0, 4.0}};
  for (int view = 0; view < 5; ++view)
    for (int light = 0; light < 3; ++light) {
      InferredSample sample;
      sample.name = "v" + std::to_string(view) + "p" + std::to_string(light);
      sample.at = {view, light};
      sample.world_to_clip[3][0] = 0.1 * view;
      if (light == 2) sample.object_to_world["vase"][3][1] = 1.5;
      field.samples.push_back(sample);
      object.mapping_of_sample.push_back(view < 3 ? 0 : 1);
    }
  field.objects = {object};
  return field;
}

std::vector<FieldBlock> blocks_of(const std::vector<std::string>& textures, int side = 8, std::size_t most = 1000,
                                  int first = 0) {
  const InferredManifest field = field_of_15();
  return field_blocks(field, sample_grid(field.samples), field.objects[0].mapping_of_sample, textures,
                      {side, first, most});
}

// Returns one name per sample, which is made from its view and its light.
std::vector<std::string> names(const std::function<std::string(int view, int light)>& name) {
  std::vector<std::string> textures;
  for (int view = 0; view < 5; ++view)
    for (int light = 0; light < 3; ++light) textures.push_back(name(view, light));
  return textures;
}

TEST(FieldBlocks, EndWhereMappingsChangeAndVaryWithWhatTexturesDo) {
  const auto of_lights = [](int view, int light) { return std::to_string(view / 3) + std::to_string(light); };
  const auto blocks = blocks_of(names(of_lights));
  ASSERT_EQ(blocks.size(), 2u);
  EXPECT_EQ(blocks[0].begin, (std::vector<int>{0, 0}));
  EXPECT_EQ(blocks[0].size, (std::vector<int>{3, 3}));
  EXPECT_EQ(blocks[1].begin, (std::vector<int>{3, 0}));
  EXPECT_EQ(blocks[1].size, (std::vector<int>{2, 3}));
  for (const FieldBlock& block : blocks) EXPECT_EQ(block.varying, (std::vector<std::size_t>{1}));
  EXPECT_EQ(blocks[1].chunk_sample({4, 2}), 2u);
  // A missing texture matches any other.
  auto missing = names(of_lights);
  missing[4].clear();
  EXPECT_EQ(blocks_of(missing)[0].varying, (std::vector<std::size_t>{1}));
  // Two textures each match a common neighbour, but they do not match each other.
  const auto diagonal = names([](int view, int light) {
    return view == 0 && light == 0 ? "a" : view == 1 && light == 1 ? "b" : "";
  });
  EXPECT_EQ(blocks_of(diagonal)[0].varying.size(), 1u);
  EXPECT_TRUE(blocks_of(names([](int view, int) { return std::to_string(view / 3); }))[0].varying.empty());
}

TEST(FieldBlocks, AreAsSmallAsIsAskedForAlongVaryingParametersAlone) {
  const auto all = names([](int view, int light) { return std::to_string(10 * view + light); });
  for (const auto& blocks : {blocks_of(all, 2), blocks_of(all, 8, 4)}) {
    std::set<std::vector<int>> begins;
    std::size_t samples = 0;
    for (const FieldBlock& block : blocks) {
      begins.insert(block.begin);
      const auto count = static_cast<std::size_t>(block.size[0] * block.size[1]);
      EXPECT_LE(count, 4u);
      samples += count;
    }
    EXPECT_EQ(samples, 15u);
    EXPECT_EQ(begins.size(), blocks.size());
  }
  EXPECT_EQ(blocks_of(names([](int, int light) { return std::to_string(light); }), 2).size(), 4u);
}

TEST(FieldBlocks, MayBeginWithAShorterOneWhereOneDoesNotHoldAll) {
  const auto all = names([](int view, int light) { return std::to_string(10 * view + light); });
  std::set<std::vector<int>> found;
  for (const FieldBlock& block : blocks_of(all, 2, 1000, 1))
    found.insert({block.begin[0], block.size[0], block.begin[1], block.size[1]});
  // Views 0 and 1..2 share one mapping; views 3..4 share the other and form one block. The blocks of lights are 0 and
  // 1..2.
  EXPECT_EQ(found, (std::set<std::vector<int>>{
                       {0, 1, 0, 1}, {0, 1, 1, 2}, {1, 2, 0, 1}, {1, 2, 1, 2}, {3, 2, 0, 1}, {3, 2, 1, 2}}));
  EXPECT_EQ(blocks_of(all, 8, 1000, 3).size(), 2u) << "one block per mapping holds everything";
  for (int first = 0; first <= 2; ++first) {
    std::size_t samples = 0;
    for (const FieldBlock& block : blocks_of(all, 2, 2, first))
      samples += block.chunk_sizes()[0] > 2 ? 0u : static_cast<std::size_t>(block.size[0] * block.size[1]);
    EXPECT_EQ(samples, 15u) << first;
  }
}

TEST(FieldDescription, ComesBackInSinglePrecision) {
  FieldDescription description;
  description.field = field_of_15();
  const InferredManifest& field = description.field;
  const SampleGrid grid = sample_grid(field.samples);
  const auto textures = names([](int view, int light) { return std::to_string(10 * view + light); });
  description.layers = {
      {0, "gloss", field_blocks(field, grid, field.objects[0].mapping_of_sample, textures, {2, 0, 9}), {3, 7}}};
  const FieldDescription read = decode_description(encode_description(description));
  ASSERT_EQ(read.field.samples.size(), 15u);
  for (std::size_t s = 0; s < 15; ++s) {
    EXPECT_EQ(read.field.samples[s].name, field.samples[s].name);
    EXPECT_EQ(read.field.samples[s].at, field.samples[s].at);
    EXPECT_EQ(glm::mat4(read.field.samples[s].world_to_clip), glm::mat4(field.samples[s].world_to_clip));
    EXPECT_EQ(read.field.samples[s].object_to_world, field.samples[s].object_to_world);
  }
  EXPECT_EQ(glm::mat2(read.field.objects[0].mappings[0].linear), glm::mat2(field.objects[0].mappings[0].linear));
  EXPECT_EQ(read.field.objects[0].mappings[0].width, 7);
  EXPECT_EQ(read.field.objects[0].mapping_of_sample, field.objects[0].mapping_of_sample);
  ASSERT_EQ(read.layers.size(), 1u);
  EXPECT_EQ(read.layers[0].unseen, (std::vector<int>{3, 7}));
  ASSERT_EQ(read.layers[0].blocks.size(), description.layers[0].blocks.size());
  for (std::size_t b = 0; b < read.layers[0].blocks.size(); ++b) {
    EXPECT_EQ(read.layers[0].blocks[b].begin, description.layers[0].blocks[b].begin);
    EXPECT_EQ(read.layers[0].blocks[b].size, description.layers[0].blocks[b].size);
    EXPECT_EQ(read.layers[0].blocks[b].varying, description.layers[0].blocks[b].varying);
  }
}

TEST(FieldDescription, WhatDoesNotFitTogetherIsRefused) {
  const auto refused = [](const std::function<void(FieldDescription&)>& change) {
    FieldDescription description;
    description.field = field_of_15();
    description.layers = {{0, "gloss", {{{0, 0}, {3, 3}, {0}}, {{3, 0}, {2, 3}, {1}}}, {}}};
    EXPECT_NO_THROW(decode_description(encode_description(description)));
    change(description);
    EXPECT_THROW(decode_description(encode_description(description)), Error);
  };
  refused([](FieldDescription& d) { d.layers[0].blocks.pop_back(); });
  refused([](FieldDescription& d) { d.layers[0].blocks[1].begin[0] = 2; });
  refused([](FieldDescription& d) { d.layers[0].blocks[1].size[0] = 1 << 30; });
  refused([](FieldDescription& d) { d.layers[0].blocks[1].begin[1] = -1; });
  refused([](FieldDescription& d) { d.layers[0].blocks[0].varying = {1, 0}; });
  refused([](FieldDescription& d) { d.layers[0].blocks[0].varying = {2}; });
  refused([](FieldDescription& d) { d.layers[0].unseen = {15}; });
  refused([](FieldDescription& d) { d.layers[0].unseen = {5, 4}; });
  refused([](FieldDescription& d) { d.field.samples[3].at = {0, 0}; });
  refused([](FieldDescription& d) { d.field.samples[3].at = {0, 1 << 30}; });
  refused([](FieldDescription& d) { d.field.samples[3].at.clear(); });
  refused([](FieldDescription& d) { d.field.objects[0].mapping_of_sample[2] = 2; });
  refused([](FieldDescription& d) { d.field.objects[0].mapping_of_sample.pop_back(); });
  refused([](FieldDescription& d) { d.field.objects[0].mappings[0].width = 0; });
  refused([](FieldDescription& d) { d.field.width = 0; });
  const std::vector<std::uint8_t> whole = encode_description({field_of_15(), {}, {}});
  for (std::size_t length = 0; length < whole.size(); length += 7)
    EXPECT_THROW(decode_description(std::span(whole).first(length)), Error);
}

// A hostile file could store one pose that thousands of samples refer to.
TEST(FieldDescription, PosesThatAreSharedAreBounded) {
  std::string zeros = "0", samples = R"(["s",[0],0,0])";
  for (int i = 0; i < 20000; ++i) zeros += ",0";
  for (int i = 0; i < 1000; ++i) samples += R"(,["s",[0],0,0])";
  const std::string text =
      R"({"samples":[)" + samples + R"(],"views":[[1]],"moves":[{"vase":[)" + zeros + R"(]}],"objects":[]})";
  std::vector<Bytef> packed(compressBound(static_cast<uLong>(text.size())));
  auto length = static_cast<uLongf>(packed.size());
  ASSERT_EQ(compress(packed.data(), &length, reinterpret_cast<const Bytef*>(text.data()), text.size()), Z_OK);
  ByteWriter writer;
  writer.number(text.size());
  writer.bytes(std::span(packed).first(length));
  testing::expect_error(ErrorCode::kInput, {"than a field can store"}, [&] { decode_description(writer.written()); });
}

}  // namespace
}  // namespace multum
