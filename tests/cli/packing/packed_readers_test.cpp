// SPDX-License-Identifier: Apache-2.0
// Tests packed fields with independent readers: a reader in Python by docs/reference/packed_fields.md (mpt_reading.py),
// and the decoder as WebAssembly in Node (tools/wasm_decoder). Both read chunks of every kind that a file may contain,
// and a field that multum packed.
#include <fmt/format.h>
#include <half.h>

#include <cmath>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/fields/codec/chunk_choice.h"
#include "host/fields/codec/decoder/mip_levels.h"
#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packed_file.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/foundation/base/split_mix.h"
#include "tests/cli/program.h"
#include "tests/cli/traced_scene.h"
#include "tools/multum_wasm/packed_field.h"

namespace multum::testing {
namespace {

struct ChunkKind {
  std::size_t width, height;
  std::vector<std::size_t> sizes;
  ChunkSettings settings;
};

std::vector<ChunkKind> all_kinds() {
  std::vector<ChunkKind> kinds;
  const auto add = [&](std::size_t width, std::size_t height, std::vector<std::size_t> sizes, ImageCoder coder,
                       std::size_t side, double lambda) -> ChunkSettings& {
    ChunkSettings settings;
    settings.coder = coder;
    settings.side = side;
    settings.lambda = lambda;
    settings.basis_images = 3;
    kinds.push_back({width, height, std::move(sizes), settings});
    return kinds.back().settings;
  };
  // Makes images with magnitudes up to some thousands, images of odd sizes and single rows, and coarse images whose
  // planes and bands are empty.
  add(21, 9, {3, 2}, ImageCoder::kDct, 8, 0.01).levels = plain_levels({3, 2});
  add(40, 19, {5}, ImageCoder::kDct, 16, 2.0).levels = {{3}, {1}, {0}};
  kinds.back().settings.linear = true;
  add(70, 33, {4}, ImageCoder::kDct, 32, 10.0);
  add(50, 20, {2, 2}, ImageCoder::kDct, 8, 400.0).levels = {{1, 1}, {0, 1}, {0, 0}};
  add(45, 26, {2, 2}, ImageCoder::kWavelet, 16, 0.5).levels = plain_levels({2, 2});
  add(37, 50, {5}, ImageCoder::kWavelet, 16, 20.0).levels = plain_levels({5});
  kinds.back().settings.linear = true;
  add(1, 7, {3}, ImageCoder::kWavelet, 16, 0.1);
  add(64, 9, {4}, ImageCoder::kWavelet, 16, 300.0);
  return kinds;
}

/// Returns colours that drift over the samples, are dark in places, and have noise.
std::vector<std::uint8_t> chunk_of(const ChunkKind& kind, std::uint64_t seed) {
  SplitMix64 random(seed);
  ChunkSource source;
  source.width = kind.width;
  source.height = kind.height;
  source.sizes = kind.sizes;
  std::size_t samples = 1;
  for (const std::size_t size : kind.sizes) samples *= size;
  for (std::size_t s = 0; s < samples; ++s) {
    std::vector<float> texture;
    for (std::size_t y = 0; y < kind.height; ++y)
      for (std::size_t x = 0; x < kind.width; ++x)
        for (std::size_t c = 0; c < 3; ++c) {
          const double wave = std::sin(0.3 * static_cast<double>(x + c * s) + 0.1 * static_cast<double>(y * c));
          const double value = 90.0 + 95.0 * wave + (x > y ? 30.0 : 0.0) + 20.0 * (random.uniform() - 0.5);
          texture.push_back(static_cast<float>(value));
        }
    source.textures.push_back(std::move(texture));
  }
  source.texel_weights.assign(kind.width * kind.height, 1.0f);
  const BlockGrid grid{kind.width, kind.height, kind.settings.side};
  const std::size_t count =
      kind.settings.coder == ImageCoder::kDct ? grid.count() * grid.side * grid.side : kind.width * kind.height;
  const CoefficientWeights weights = [count](std::size_t) { return std::vector<float>(count, 1.0f); };
  return ChunkEncoder(source, weights, kind.settings.coder, kind.settings.side).encode(kind.settings, [] {}).bytes;
}

std::vector<std::unique_ptr<TextureChunk>> decoded_chunks(const std::string& path, nlohmann::json& list) {
  const std::string file = read_bytes(path);
  const std::vector<std::uint8_t> bytes(file.begin(), file.end());
  std::string problem;
  const auto index = PackedIndex::read(bytes, problem);
  EXPECT_TRUE(index) << problem;
  std::vector<std::unique_ptr<TextureChunk>> chunks;
  list = nlohmann::json::array();
  for (const PackedSection& section : index->sections()) {
    if (section.kind != static_cast<std::uint32_t>(SectionKind::kChunk)) continue;
    chunks.push_back(TextureChunk::decode(std::span(bytes).subspan(section.offset, section.length), problem));
    const TextureChunkFormat& format = chunks.back()->format();
    list.push_back({section.layer, section.block, format.width, format.height, chunks.back()->sample_count()});
  }
  return chunks;
}

class PackedReadersTest : public TracedSceneTest {
 protected:
  void write_all_kinds() {
    std::vector<std::vector<std::uint8_t>> chunks;
    for (const ChunkKind& kind : all_kinds()) chunks.push_back(chunk_of(kind, 7 + chunks.size()));
    std::vector<SectionSource> sections = {{9, 3, 4, {1, 2, 3}}};  // a kind of section that later versions may add
    for (std::size_t i = 0; i < chunks.size(); ++i)
      sections.push_back({1, static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(200 * i), chunks[i]});
    const std::vector<std::uint8_t> file = packed_file(sections);
    write_bytes(path("kinds.mpt"), std::string(file.begin(), file.end()));
  }
  void pack_traced_scene() {
    TracedScene scene;
    scene.views = 2;
    infer_scene(scene);
    ASSERT_EQ(multum({"pack", path("out"), "-o", path("field.mpt"), "--lambda", "100"}).exit_code, 0);
    ASSERT_EQ(multum({"unpack", path("field.mpt"), "-o", path("unpacked")}).exit_code, 0);
  }
  ProgramResult python(const std::vector<std::string>& arguments) const {
    std::vector<std::string> command = {MULTUM_NUMPY_PYTHON, MULTUM_SOURCE_DIR "/tests/cli/packing/mpt_reading.py"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    return run_program(command);
  }
};

std::vector<float> floats_of(const std::string& bytes) {
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
}

// Both decoders compute in single precision and in the same order. The full range is 255, so a tolerance of 0.001
// allows hundreds of roundings.
TEST_F(PackedReadersTest, PythonDecodesChunksOfEveryKind) {
  if (std::string(MULTUM_NUMPY_PYTHON).empty()) GTEST_SKIP() << "no numpy (Debian package python3-numpy)";
  write_all_kinds();
  const ProgramResult result = python({path("kinds.mpt"), path("textures")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  nlohmann::json list;
  const auto chunks = decoded_chunks(path("kinds.mpt"), list);
  EXPECT_EQ(nlohmann::json::parse(result.out)["chunks"], list);
  const std::vector<float> found = floats_of(read_bytes(path("textures")));
  std::size_t at = 0;
  for (std::size_t i = 0; i < chunks.size(); ++i)
    for (std::size_t s = 0; s < chunks[i]->sample_count(); ++s)
      for (const float value : chunks[i]->texture(s)) {
        ASSERT_LT(at, found.size());
        ASSERT_NEAR(found[at++], value, 1e-3f) << "chunk " << i << ", sample " << s;
      }
  EXPECT_EQ(at, found.size());
}

// Compares every texture of every sample in the field's description, including its mip levels, with the result of
// `multum unpack`. The tolerance covers 16-bit floats, whose error is 2^-11 of a value, or 2^-25 for values below
// 2^-14. The other steps use single precision.
TEST_F(PackedReadersTest, PythonFindsTheTexturesThatAreUnpacked) {
  if (std::string(MULTUM_NUMPY_PYTHON).empty()) GTEST_SKIP() << "no numpy (Debian package python3-numpy)";
  pack_traced_scene();
  const ProgramResult result = python({"--field", path("field.mpt"), path("textures")});
  ASSERT_EQ(result.exit_code, 0) << result.err;
  const std::vector<float> found = floats_of(read_bytes(path("textures")));
  const InferredManifest manifest = read_inferred_manifest(path("unpacked/inferred.json"));
  std::size_t at = 0, textures = 0;
  for (const InferredObject& object : manifest.objects)
    for (const InferredLayer& layer : object.layers)
      for (std::size_t s = 0; s < layer.textures.size(); ++s) {
        if (layer.textures[s].empty()) continue;
        ++textures;
        for (const float value : read_inferred_texture(path("unpacked/" + layer.textures[s])).texels) {
          ASSERT_LT(at, found.size());
          ASSERT_NEAR(found[at++], value, value * 0x1p-11f + 1e-6f) << layer.textures[s];
        }
      }
  EXPECT_EQ(at, found.size());
  EXPECT_GE(textures, manifest.samples.size());
  // The reader notices damage.
  std::string bytes = read_bytes(path("field.mpt"));
  bytes[bytes.size() - 5] = static_cast<char>(bytes[bytes.size() - 5] ^ 1);
  write_bytes(path("bad.mpt"), bytes);
  const ProgramResult bad = python({"--field", path("bad.mpt"), path("textures")});
  EXPECT_NE(bad.exit_code, 0);
  EXPECT_NE(bad.err.find("damaged"), std::string::npos) << bad.err;
}

// Decodes a file with the native decoder, and returns the bytes that decode_in_node.mjs would write.
std::string native_bytes(const std::string& path) {
  const std::string file = read_bytes(path);
  MultumPackedField* field = multum_open(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
  EXPECT_NE(field, nullptr) << multum_problem();
  std::string all;
  for (std::size_t i = 0; i < multum_chunk_count(field); ++i) {
    MultumTextureChunk* chunk = multum_decode(field, i);
    EXPECT_NE(chunk, nullptr) << multum_problem();
    const std::size_t values = 3 * multum_width(chunk) * multum_height(chunk);
    std::vector<float> floats(values);
    std::vector<std::uint16_t> halves(values);
    for (std::size_t s = 0; s < multum_sample_count(chunk); ++s) {
      multum_texture(chunk, s, floats.data());
      multum_radiance_halves(chunk, s, halves.data());
      all.append(reinterpret_cast<const char*>(floats.data()), 4 * values);
      all.append(reinterpret_cast<const char*>(halves.data()), 2 * values);
    }
    multum_chunk_close(chunk);
  }
  multum_close(field);
  return all;
}

TEST_F(PackedReadersTest, FunctionsForWebAssemblyGiveWhatTheDecoderGives) {
  write_all_kinds();
  nlohmann::json list;
  const auto chunks = decoded_chunks(path("kinds.mpt"), list);
  const std::string bytes = native_bytes(path("kinds.mpt"));
  std::size_t at = 0, denormal = 0;
  for (const auto& chunk : chunks)
    for (std::size_t s = 0; s < chunk->sample_count(); ++s) {
      const std::vector<float> texture = chunk->texture(s);
      ASSERT_EQ(std::memcmp(bytes.data() + at, texture.data(), 4 * texture.size()), 0);
      at += 4 * texture.size();
      for (const float value : texture) {
        std::uint16_t bits = 0;
        std::memcpy(&bits, bytes.data() + at, 2);
        ASSERT_EQ(bits, half(radiance_of(value)).bits()) << value;
        denormal += bits > 0 && bits < 0x400 ? 1 : 0;
        at += 2;
      }
    }
  EXPECT_EQ(at, bytes.size());
  EXPECT_GT(denormal, 100u);
  // Decodes a single section, with mip levels.
  const std::vector<std::uint8_t> section = chunk_of(all_kinds()[1], 8);
  MultumTextureChunk* alone = multum_decode_section(section.data(), section.size());
  ASSERT_NE(alone, nullptr) << multum_problem();
  std::vector<float> finest = chunks[1]->texture(2);
  std::transform(finest.begin(), finest.end(), finest.begin(), radiance_of);
  const std::vector<float> levels = mip_levels(multum_width(alone), multum_height(alone), finest);
  ASSERT_EQ(levels.size(), 3 * multum_level_texels(alone));
  std::vector<std::uint16_t> halves(levels.size());
  multum_radiance_levels(alone, 2, halves.data());
  for (std::size_t i = 0; i < levels.size(); ++i) ASSERT_EQ(halves[i], half(levels[i]).bits()) << i;
  multum_chunk_close(alone);
  EXPECT_EQ(multum_decode_section(section.data(), 3), nullptr);
  const std::string file = read_bytes(path("kinds.mpt"));
  const auto open = [&](const std::string& text) {
    return multum_open(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
  };
  EXPECT_EQ(open(file + "x"), nullptr);
  EXPECT_NE(std::string(multum_problem()).find("longer or shorter"), std::string::npos);
  EXPECT_EQ(open("MPTF"), nullptr);
  EXPECT_NE(std::string(multum_problem()), "");
  std::string damaged = file;
  damaged.back() = static_cast<char>(damaged.back() ^ 1);
  MultumPackedField* field = open(damaged);
  ASSERT_NE(field, nullptr);
  EXPECT_EQ(multum_description_length(field), 0u);
  EXPECT_EQ(multum_decode(field, multum_chunk_count(field) - 1), nullptr);
  EXPECT_NE(std::string(multum_problem()).find("checksum"), std::string::npos);
  multum_close(field);
}

TEST_F(PackedReadersTest, InNodeTheModuleGivesTheSameBytes) {
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  const std::string script = MULTUM_SOURCE_DIR "/tools/wasm_decoder";
  const ProgramResult there = run_program({script, "--check"});
  if (there.exit_code == 3) GTEST_SKIP() << there.err;
  const ProgramResult made = run_program({script, path("module")});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  write_all_kinds();
  pack_traced_scene();
  for (const std::string name : {"kinds.mpt", "field.mpt"}) {
    const std::string decoding = MULTUM_SOURCE_DIR "/tests/cli/packing/decode_in_node.mjs";
    const ProgramResult result = run_program({"node", decoding, path("module"), path(name), path("decoded")});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_TRUE(read_bytes(path("decoded")) == native_bytes(path(name))) << name;
    const auto said = nlohmann::json::parse(result.out);
    nlohmann::json list;
    decoded_chunks(path(name), list);
    EXPECT_EQ(said["chunks"], list);
    ASSERT_EQ(said["refused"].size(), 3u);
    for (const char* part : {"longer or shorter", "checksum of its index", "checksum differs"}) {
      const auto has = [&](const nlohmann::json& text) {
        return text.get<std::string>().find(part) != std::string::npos;
      };
      EXPECT_TRUE(std::any_of(said["refused"].begin(), said["refused"].end(), has)) << part << " in " << said;
    }
    EXPECT_EQ(said["description"].is_null(), name == std::string("kinds.mpt"));
    if (!said["description"].is_null()) {
      EXPECT_EQ(said["description"]["samples"].size(), PackedFieldFile(path(name)).description().field.samples.size());
    }
  }
}

}  // namespace
}  // namespace multum::testing
