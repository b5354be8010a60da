// SPDX-License-Identifier: Apache-2.0
// Tests the players that `multum pack` and `multum player` write: their contents and refusals. In headless Chromium,
// player_test.mjs compares their pictures with those of multum-view, and tests controls, memory, and damage of every
// kind.
#include <filesystem>
#include <nlohmann/json.hpp>

#include "host/fields/codec/field_unpacking.h"
#include "host/fields/codec/packed_file.h"
#include "host/fields/inferred/inferred_texture.h"
#include "host/fields/player/player_files.h"
#include "host/fields/player/player_output.h"
#include "host/fields/player/scene_glb.h"
#include "host/formats/mesh/object_mesh.h"
#include "tests/cli/program.h"
#include "tests/cli/traced_scene.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

bool has_wasm() { return player_module_files().count("packed_field.wasm") > 0; }

class PlayerPageTest : public TracedSceneTest {
 protected:
  void pack_with_player() {
    TracedScene scene;
    scene.views = 3;
    infer_scene(scene);
    const ProgramResult packed = multum({"pack", path("out"), "-o", path("field.mpt"), "--lambda", "1", "--player",
                                         path("player"), "--page", path("page.html")});
    ASSERT_EQ(packed.exit_code, 0) << packed.err;
    expect_says(packed.out, {"player: written", "page.html: written"});
  }

  /// Draws every sample with multum-view, and writes a list of the pictures for the browser.
  void draw_samples() {
    ASSERT_EQ(multum({"unpack", path("field.mpt"), "-o", path("unpacked")}).exit_code, 0);
    std::vector<std::string> command = {std::string(MULTUM_BIN_DIR) + "/multum-view", "sample", path("unpacked"),
                                        "--context", "osmesa"};
    nlohmann::json list = nlohmann::json::array();
    for (const InferredSample& sample : read_inferred_manifest(path("unpacked/inferred.json")).samples) {
      const std::string picture = sample.name + ".png";
      command.insert(command.end(), {"--at", sample.name, "-o", path(picture)});
      list.push_back({{"at", sample.at}, {"picture", picture}});
    }
    const ProgramResult drawn = run_program(command);
    ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
    write_bytes(path("expected.json"), list.dump());
  }
};

TEST_F(PlayerPageTest, InChromium) {
  if (!has_wasm()) GTEST_SKIP() << "no compiler for WebAssembly: tools/wasm_decoder --check";
  if (!program_works("node", "--version")) GTEST_SKIP() << "no node (Debian package nodejs)";
  const std::string browser = chromium_path();
  if (browser.empty()) GTEST_SKIP() << "no chromium-headless-shell: tools/install_dependencies test";
  if (!fs::exists(MULTUM_SOURCE_DIR "/tests/service/web/node_modules/playwright-core"))
    GTEST_SKIP() << "no playwright-core: tools/install_dependencies test";
  pack_with_player();
  draw_samples();
  fs::create_directories(MULTUM_SCREENSHOTS);
  const ProgramResult walked =
      run_program({"node", MULTUM_SOURCE_DIR "/tests/player/player_test.mjs", browser, path(""), MULTUM_SCREENSHOTS});
  EXPECT_EQ(walked.exit_code, 0) << walked.out << walked.err;
  std::printf("%s", walked.out.c_str());
}

TEST_F(PlayerPageTest, AFieldIsPublishedLater) {
  if (!has_wasm()) GTEST_SKIP() << "no compiler for WebAssembly: tools/wasm_decoder --check";
  pack_with_player();
  EXPECT_EQ(multum({"player", path("field.mpt"), "-o", path("again")}).exit_code, 0);
  for (const auto& entry : fs::directory_iterator(path("player")))
    EXPECT_TRUE(read_bytes(entry.path().string()) == read_bytes(path("again/" + entry.path().filename().string())))
        << entry.path();
  EXPECT_EQ(multum({"player", path("field.mpt"), "-o", path("again.html")}).exit_code, 0);
  EXPECT_TRUE(read_bytes(path("again.html")) == read_bytes(path("page.html")));
  // Without escaping, this title would end the script that contains it.
  fs::copy_file(path("field.mpt"), path("<!--<script>.mpt"));
  ASSERT_EQ(multum({"player", path("<!--<script>.mpt"), "-o", path("named.html")}).exit_code, 0);
  EXPECT_EQ(read_bytes(path("named.html")).find("<!--<script>"), std::string::npos);
  // This geometry differs from the geometry for which the textures were made.
  write_bytes(path("renders/geometry.obj"), read_bytes(path("renders/geometry.obj")) + "\n# changed\n");
  expect_refusal(multum({"player", path("field.mpt"), "-o", path("other")}), kInput,
                 {"geometry.obj", "not the geometry", "SHA-256"});
  EXPECT_FALSE(fs::exists(path("other")));
}

TEST_F(PlayerPageTest, NamesAreRefusedBeforeAnyWork) {
  if (!has_wasm()) GTEST_SKIP() << "no compiler for WebAssembly: tools/wasm_decoder --check";
  write_bytes(path("file"), "a file");
  const auto pack = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"pack", path("out"), "-o", path("field.mpt")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum(arguments);
  };
  expect_refusal(pack({"--page", path("page.mpt")}), kUsage, {"page.mpt", "*.html"});
  expect_refusal(pack({"--player", path("file")}), kUsage, {"is a file", "a folder"});
  expect_refusal(pack({"--player", path("x.html"), "--page", path("x.html")}), kUsage, {"named twice"});
  expect_refusal(multum({"player", path("field.mpt"), "-o", path("x")}), kInput, {"field.mpt"});
}

TEST_F(PlayerPageTest, APageThatWouldBeTooLargeIsRefused) {
  if (!has_wasm()) GTEST_SKIP() << "no compiler for WebAssembly: tools/wasm_decoder --check";
  pack_with_player();
  PackedFieldFile small(path("field.mpt"));
  std::vector<SectionSource> sections = {{9, 0, 0, std::vector<std::uint8_t>(kPlayerPageBytesMax)}};  // a later kind
  for (std::size_t i = 0; i < small.index().sections().size(); ++i) {
    const PackedSection& section = small.index().sections()[i];
    sections.push_back({section.kind, section.layer, section.block, small.section(i)});
  }
  const std::vector<std::uint8_t> large = packed_file(sections);
  write_bytes(path("large.mpt"), std::string(large.begin(), large.end()));
  expect_refusal(multum({"player", path("large.mpt"), "-o", path("large.html")}), kUsage,
                 {"large.html", "a page can hold at most 16777216", "expected a folder"});
  EXPECT_FALSE(fs::exists(path("large.html")));
  EXPECT_EQ(multum({"player", path("large.mpt"), "-o", path("large")}).exit_code, 0);
}

TEST_F(PlayerPageTest, WithoutADecoderForBrowsersThatIsSaid) {
  if (has_wasm()) GTEST_SKIP() << "this build has one";
  for (const std::vector<std::string>& more :
       {std::vector<std::string>{"--page", path("page.html")}, std::vector<std::string>{"--player", path("player")}}) {
    std::vector<std::string> arguments = {"pack", path("out"), "-o", path("field.mpt")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_refusal(multum(arguments), kEnvironment, {"without the decoder for browsers", "apt-get install clang"});
  }
  expect_refusal(multum({"player", path("field.mpt"), "-o", path("player")}), kEnvironment, {"apt-get install clang"});
}

// Compares the model with the result of assimp, because the browser must draw the same geometry as multum-view.
TEST_F(PlayerPageTest, TheGeometryIsReadBackAsItWas) {
  write_scene(TracedScene{});
  const std::vector<ObjectMesh> objects = read_object_meshes(path("renders/geometry.obj"), 0);
  write_bytes(path("geometry.glb"), scene_glb(objects, 0));
  const std::vector<ObjectMesh> again = read_object_meshes(path("geometry.glb"), 0);
  ASSERT_EQ(again.size(), objects.size());
  for (std::size_t i = 0; i < objects.size(); ++i) {
    EXPECT_EQ(again[i].name, objects[i].name);
    EXPECT_EQ(again[i].indices, objects[i].indices);
    EXPECT_EQ(again[i].positions, objects[i].positions);
    EXPECT_EQ(again[i].object_to_world, objects[i].object_to_world);
    ASSERT_EQ(again[i].uvs.size(), objects[i].uvs.size());
    for (std::size_t k = 0; k < objects[i].uvs.size(); ++k) {
      EXPECT_FLOAT_EQ(again[i].uvs[k].x, objects[i].uvs[k].x);
      EXPECT_FLOAT_EQ(again[i].uvs[k].y, objects[i].uvs[k].y);
    }
  }
}

}  // namespace
}  // namespace multum::testing
