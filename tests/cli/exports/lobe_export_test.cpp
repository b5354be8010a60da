// SPDX-License-Identifier: Apache-2.0
// Tests multum export --lobes: the file as ktx-parse and multum read it, the difference between stored and baked lobes,
// a picture that multum-view draws, and the refusals.
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/formats/asset/lobes/movmf_mipmap.h"
#include "host/formats/asset/textures/lobe_texture.h"
#include "tests/cli/program.h"
#include "tests/fixtures/lobe_texture_file.h"

namespace multum::testing {
namespace {

class LobeExportTest : public CliTest {
 protected:
  void SetUp() override {
    make_map("map", 64);
    ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "--no-measure"}).exit_code, 0);
  }
  ProgramResult run(std::vector<std::string> more) const {
    more.insert(more.begin(), {"export", path("map.ndf.exr"), "--lobes", "-o", path("map.ktx2")});
    return multum(more);
  }
  void expect_refused(const std::vector<std::string>& arguments, int code,
                      const std::vector<std::string>& parts) const {
    expect_refusal(multum(arguments), code, parts);
    EXPECT_FALSE(std::filesystem::exists(path("out.ktx2")));
  }
  void expect_damaged(std::string bytes, const std::string& part) const {
    write_bytes(path("bad.ktx2"), bytes);
    try {
      read_lobe_texture(path("bad.ktx2"));
      ADD_FAILURE() << "was read: " << part;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput);
      expect_says(error.what(), {"bad.ktx2", part});
    }
  }
};

// Holds root mean square errors of amplitudes and mean vectors, over all stored texels.
struct StorageError {
  double amplitude = 0.0, vector = 0.0, spread = 0.0;
};

StorageError storage_error(const MovmfMipmap& baked, const MovmfMipmap& stored) {
  StorageError sum;
  double count = 0.0;
  for (std::size_t l = static_cast<std::size_t>(stored.header.first_level); l < stored.levels.size(); ++l)
    for (std::size_t j = 0; j < stored.levels[l].lobes.size(); ++j)
      for (std::size_t i = 0; i < stored.levels[l].lobes[j].size(); ++i) {
        const glm::dvec4 a = baked.levels[l].lobes[j][i], b = stored.levels[l].lobes[j][i];
        const auto shortfall = [](const glm::dvec4& lobe) { return lobe.w - glm::length(glm::dvec3(lobe)); };
        sum.amplitude += (a.w - b.w) * (a.w - b.w);
        sum.vector += glm::dot(glm::dvec3(a - b), glm::dvec3(a - b));
        sum.spread += std::pow(shortfall(a) - std::max(shortfall(b), 0.0), 2.0);
        ++count;
      }
  return {std::sqrt(sum.amplitude / count), std::sqrt(sum.vector / count), std::sqrt(sum.spread / count)};
}

TEST_F(LobeExportTest, StoresTheLobes) {
  const MovmfMipmap baked = read_movmf_mipmap(path("map.ndf.exr"));
  // These errors are expected: 16-bit floats have 11 bits of precision, 8 bits of a lobe's range give 1/255 / sqrt(12)
  // per channel, and BC4 gives a seventh of a block's span. The coarsest levels do not fill their blocks, so all levels
  // of a 64 x 64 map take more than 4/3 of the size of the first level.
  const struct {
    const char* texels;
    double bytes_ratio;
    StorageError most;
  } cases[] = {
      {"rgba16f", 5.34, {1e-4, 2e-4, 1e-4}}, {"rgba8", 2.67, {1.5e-3, 3e-3, 1.5e-3}}, {"bc", 1.36, {0.02, 0.03, 0.02}}};
  for (const auto& one : cases) {
    SCOPED_TRACE(one.texels);
    const ProgramResult result = run({"--texels", one.texels, "--report", path("r.json")});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const auto report = nlohmann::json::parse(read_bytes(path("r.json")));
    EXPECT_LT(report["bytes_ratio"], one.bytes_ratio);
    const LobeTexture texture = read_lobe_texture(path("map.ktx2"));
    EXPECT_EQ(lobe_texture_bytes(texture.header), report["gpu_bytes"]);
    EXPECT_EQ(texture.header.map.first_level, 1);
    EXPECT_EQ(texture.header.map.provenance.source_hash, baked.header.provenance.source_hash);
    const StorageError error = storage_error(baked, unpacked_mipmap(texture));
    EXPECT_LT(error.amplitude, one.most.amplitude);
    EXPECT_LT(error.vector, one.most.vector);
    EXPECT_LT(error.spread, one.most.spread);
    EXPECT_GT(error.vector, 0.0);
    // Zstandard is lossless.
    ASSERT_EQ(run({"--texels", one.texels, "--zstd", "5"}).exit_code, 0);
    EXPECT_EQ(read_lobe_texture(path("map.ktx2")).levels, texture.levels);
  }
}

TEST_F(LobeExportTest, KtxParseReadsIt) {
  const std::string script = MULTUM_SOURCE_DIR "/tests/cli/exports/ktx2_reading.mjs";
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  if (run_program({"node", script}).exit_code != 0) GTEST_SKIP() << "no ktx-parse: tools/install_dependencies test";
  ASSERT_EQ(run({}).exit_code, 0);
  const ProgramResult read = run_program({"node", script, path("map.ktx2")});
  ASSERT_EQ(read.exit_code, 0) << read.err;
  const auto file = nlohmann::json::parse(read.out)[0];
  EXPECT_EQ(file["vkFormat"], 141);
  EXPECT_EQ(file["size"], (nlohmann::json{32, 32, 0}));
  EXPECT_EQ(file["counts"], (nlohmann::json{8, 1}));
  ASSERT_EQ(file["levels"].size(), 6u);
  EXPECT_EQ(file["levels"][0]["length"], 8 * 64 * 16);
  EXPECT_EQ(file["levels"][5]["length"], 8 * 16);
  const auto key = nlohmann::json::parse(file["keys"]["multumLobes"].get<std::string>().c_str());
  EXPECT_EQ(key["mapWidth"], 64);
  EXPECT_EQ(key["lobes"].size(), 4u);
  EXPECT_EQ(key["lobes"][3]["columns"].size(), 4u);
}

TEST_F(LobeExportTest, MultumViewDrawsIt) {
  if (!std::filesystem::exists(std::string(MULTUM_BIN_DIR) + "/multum-view"))
    GTEST_SKIP() << "no multum-view was built";
  // The picture's error against the reference must be within 10 % of the baked lobes' error.
  const auto error_of = [&](const std::string& file) {
    const ProgramResult result =
        run_program({std::string(MULTUM_BIN_DIR) + "/multum-view", path(file), "--source", path("map_normal.png"),
                     "--size", "160x120", "--brdf", "blinn-phong:100", "--light", "0.3,0.8,0.5", "--compare",
                     "reference", "--samples", "64", "-o", path("p.png"), "--report", path("p.json")});
    EXPECT_EQ(result.exit_code, 0) << result.err;
    return nlohmann::json::parse(read_bytes(path("p.json")))["pictures"][1]["relative_l1"].get<double>();
  };
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("first.ndf.exr"), "--first-level", "1", "--no-measure"})
                .exit_code,
            0);
  const double baked = error_of("first.ndf.exr");
  for (const char* texels : {"rgba16f", "rgba8", "bc"}) {
    ASSERT_EQ(run({"--texels", texels}).exit_code, 0);
    EXPECT_NEAR(error_of("map.ktx2") / baked, 1.0, 0.1) << texels;
  }
}

TEST_F(LobeExportTest, RefusesWhatItCannotStore) {
  const std::string baked = path("map.ndf.exr"), out = path("out.ktx2");
  expect_refused({"export", baked, "--lobes", "-o", path("out.dds")}, kUsage, {"out.dds", "NAME.ktx2"});
  expect_refused({"export", baked, "--lobes", "-o", out, "--texels", "rg8"}, kUsage, {"--texels", "rg8", "bc"});
  expect_refused({"export", baked, "--lobes", "-o", out, "--green", "up"}, kUsage, {"--green"});
  expect_refused({"export", baked, "--lobes", "-o", out, "--anisotropy"}, kUsage, {"--anisotropy"});
  expect_refused({"export", path("map_normal.png"), "--lobes", "-o", out}, kInput, {"map_normal.png"});
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("m.ndf.exr"), "--ndf", "moments"}).exit_code, 0);
  expect_refused({"export", path("m.ndf.exr"), "--lobes", "-o", out}, kInput, {"m.ndf.exr", "no vMF lobes"});
}

TEST_F(LobeExportTest, RefusesDamagedFiles) {
  ASSERT_EQ(run({}).exit_code, 0);
  const std::string good = read_bytes(path("map.ktx2"));
  const auto with = [&](std::size_t at, char value) {
    std::string bytes = good;
    bytes[at] = value;
    return bytes;
  };
  expect_damaged("", "identifier");
  expect_damaged(with(1, 'X'), "identifier");
  expect_damaged(with(12, 99), "VkFormat 99");
  expect_damaged(with(20, 31), "width 31");
  expect_damaged(with(32, 7), "layers 7");
  expect_damaged(with(40, 5), "levels 5");
  expect_damaged(with(44, 3), "supercompression 3");
  expect_damaged(with(87, 0x7f), "beyond the end");
  expect_damaged(with(96, 1), "bytes of level 0");
  expect_damaged(with(63, 0x7f), "key/value data");
  expect_damaged(good.substr(0, good.size() - 1), "beyond the end");
  for (const auto& [from, to] :
       {std::pair{"\"version\":1", "\"version\":2"}, std::pair{"\"firstLevel\":1", "\"firstLevel\":9"},
        std::pair{"\"mapWidth\":64", "\"mapWidth\":-4"}, std::pair{"{\"version", "[\"version"}}) {
    std::string bytes = good;
    bytes.replace(bytes.find(from), std::string(from).size(), to);
    expect_damaged(bytes, "bad.ktx2");
  }
}

// The reader once allocated 17 GB for such a file.
TEST_F(LobeExportTest, AShortFileCannotAskForMuchMemory) {
  LobeTextureHeader header;
  header.map.width = header.map.height = 32768;
  header.map.first_level = 1;
  header.lobes.resize(8);
  const std::string bytes = lobe_texture_file(header, true, 1000);
  ASSERT_LT(bytes.size(), 8192u);
  expect_damaged(bytes, "compressed bytes of level 0, expected 17179869184 bytes");
}

}  // namespace
}  // namespace multum::testing
