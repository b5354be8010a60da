// SPDX-License-Identifier: Apache-2.0
// Makes a packed field whose textures are waves. The field has two objects. Its layers are pyramids and bases, and both
// coders are used. One object changes the size of its texture halfway through the views.
#pragma once

#include <array>
#include <fstream>
#include <string>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packed_file.h"
#include "host/fields/codec/texture_chunk_encoder.h"
#include "tests/unit/fields/codec/codec_test_data.h"

namespace multum::testing {

constexpr int kFieldViews = 6, kFieldLights = 4;

inline InferredObject small_object(const std::string& name, std::vector<std::array<int, 2>> sizes) {
  InferredObject object;
  object.name = object.mesh = name;
  for (const auto& [width, height] : sizes) {
    object.mappings.emplace_back();
    object.mappings.back().width = width;
    object.mappings.back().height = height;
  }
  for (int view = 0; view < kFieldViews; ++view)
    for (int light = 0; light < kFieldLights; ++light)
      object.mapping_of_sample.push_back(view * static_cast<int>(sizes.size()) / kFieldViews);
  return object;
}

/// Layer 0 is the ground's diffuse layer, which depends only on lights. Layer 1 is the ground's glossy layer in two
/// blocks of views. Layer 2 is the board's glossy layer with one block per size. Sample 0 has no texture of layer 2.
inline FieldDescription small_description() {
  FieldDescription description;
  InferredManifest& field = description.field;
  field.geometry_file = "scene.obj";
  field.geometry_hash = "0";
  field.width = 64;
  field.height = 48;
  field.supersampling = 2;
  field.parameters = {"view", "light"};
  for (int view = 0; view < kFieldViews; ++view)
    for (int light = 0; light < kFieldLights; ++light) {
      InferredSample sample;
      sample.name = std::to_string(view) + "_" + std::to_string(light);
      sample.at = {view, light};
      field.samples.push_back(sample);
    }
  field.objects = {small_object("ground", {{90, 52}}), small_object("board", {{64, 32}, {42, 80}})};
  description.grid = sample_grid(field.samples);
  description.layers.push_back({0, "diffuse", {{{0, 0}, {6, 4}, {1}}}, {}});
  description.layers.push_back({0, "glossy", {{{0, 0}, {4, 4}, {0, 1}}, {{4, 0}, {2, 4}, {0, 1}}}, {}});
  description.layers.push_back({1, "glossy", {{{0, 0}, {3, 4}, {0, 1}}, {{3, 0}, {3, 4}, {0, 1}}}, {0}});
  return description;
}

inline std::vector<std::uint8_t> small_chunk(const FieldDescription& description, std::size_t layer, std::size_t block,
                                             SplitMix64& random) {
  const FieldBlock& place = description.layers[layer].blocks[block];
  const InferredObject& object = description.field.objects[description.layers[layer].object];
  const std::size_t first = description.grid.samples_in(place).back();
  const TextureMapping& mapping = object.mappings[static_cast<std::size_t>(object.mapping_of_sample[first])];
  ChunkSource source;
  source.width = static_cast<std::size_t>(mapping.width);
  source.height = static_cast<std::size_t>(mapping.height);
  source.sizes = place.chunk_sizes();
  std::size_t count = 1;
  for (const std::size_t size : source.sizes) count *= size;
  for (std::size_t s = 0; s < count; ++s) {
    const auto plane = test_plane(source.width, source.height, 0.3 * static_cast<double>(s + 7 * block), 3.0, random);
    std::vector<float> texture;
    for (std::size_t i = 0; i < plane.size(); ++i)
      texture.insert(texture.end(), {plane[i] * 0.4f + 20.0f, plane[i], static_cast<float>(30 * layer)});
    source.textures.push_back(std::move(texture));
  }
  const std::size_t texels = source.width * source.height;
  source.texel_weights.assign(texels, 1.0f);
  ChunkSettings settings;
  settings.lambda = 4.0;
  settings.side = 8;
  settings.coder = (layer + block) % 2 == 0 ? ImageCoder::kDct : ImageCoder::kWavelet;
  settings.basis_images = 4;
  if (layer == 1) settings.levels = {{2, 2}, {1, 1}, {0, 0}};
  settings.linear = layer == 1 && block == 1;
  const std::size_t blocks = (source.width + 7) / 8 * ((source.height + 7) / 8);
  const std::size_t coefficients = settings.coder == ImageCoder::kDct ? 64 * blocks : texels;
  const CoefficientWeights weights = [coefficients](std::size_t) { return std::vector<float>(coefficients, 1.0f); };
  return ChunkEncoder(source, weights, settings.coder, settings.side).encode(settings, [] {}).bytes;
}

inline void write_packed(const FieldDescription& description, const std::vector<SectionSource>& chunks,
                         const std::string& path) {
  std::vector<SectionSource> sections = {{0, 0, 0, encode_description(description)}};
  sections.insert(sections.end(), chunks.begin(), chunks.end());
  const std::vector<std::uint8_t> bytes = packed_file(sections);
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

inline std::vector<SectionSource> small_chunks(const FieldDescription& description) {
  SplitMix64 random(26);
  std::vector<SectionSource> chunks;
  for (std::size_t l = 0; l < description.layers.size(); ++l)
    for (std::size_t b = 0; b < description.layers[l].blocks.size(); ++b)
      chunks.push_back(
          {1, static_cast<std::uint32_t>(l), static_cast<std::uint32_t>(b), small_chunk(description, l, b, random)});
  return chunks;
}

}  // namespace multum::testing
