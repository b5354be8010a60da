// SPDX-License-Identifier: Apache-2.0
// Tests the presets of multum export --for: the files, the texels, the printed line, the options that replace parts of
// a preset, and the maps whose sides an engine refuses.
#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>

#include "host/delivery/export/engines/texture_names.h"
#include "tests/cli/exports/exported_levels.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class ExportPresetsTest : public CliTest {
 protected:
  static constexpr int kSide = 32;

  void SetUp() override {
    write_test_image(path("rock_normal.png"), normal_image(kSide, kSide));
    TestImage maps{.width = kSide, .height = kSide, .channels = 3};
    for (int i = 0; i < kSide * kSide; ++i)
      for (const double value : {0.25, 0.3 + 0.4 * (i % kSide) / kSide, 0.75})
        maps.values.push_back(static_cast<float>(value));
    write_test_image(path("maps.png"), maps);
  }

  ProgramResult run(const std::string& output, std::vector<std::string> more,
                    const std::string& input = "rock_normal.png") const {
    more.insert(more.begin(),
                {"export", path(input), "-o", path(output), "--bumpformat", "normal", "--green", "up", "--no-measure"});
    return multum(more);
  }
  ProgramResult run_with_maps(const std::string& output, std::vector<std::string> more) const {
    const std::string maps = path("maps.png");
    more.insert(more.begin(), {"--roughness", maps, "--occlusion", maps, "--metalness", maps});
    return run(output, more);
  }
  std::set<std::string> files_in(const std::string& folder) const {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(path(folder)))
      names.insert(entry.path().filename().string());
    return names;
  }
  // Returns the texel at (3, 4) of level 0.
  std::vector<float> texel(const std::string& file, TexelFormat format) const {
    const std::string bytes = level_of(read_bytes(path(file)), format, kSide, kSide, 0);
    const std::vector<float> texels = decoded_level(bytes, format, kSide, kSide);
    return {texels.begin() + 4 * (4 * kSide + 3), texels.begin() + 4 * (4 * kSide + 4)};
  }
};

// The expected values are those of the engines' sources and documentation (docs/contributing/DEPENDENCIES.md).
TEST_F(ExportPresetsTest, WritesWhatEachEngineLoads) {
  const struct {
    const char *engine, *extension;
    std::set<std::string> files;
  } engines[] = {{"unreal", ".dds", {"T_rock_N.dds", "T_rock_ORM.dds"}},
                 {"unity", ".dds", {"rock_Normal.dds", "rock_MaskMap.dds"}},
                 {"unity-hdrp", ".dds", {"rock_Normal.dds", "rock_MaskMap.dds"}},
                 {"godot", ".dds", {"rock_normal.dds", "rock_orm.dds"}},
                 {"o3de", ".dds", {"rock_normal.dds", "rock_roughness.dds", "rock_ao.dds", "rock_metallic.dds"}},
                 {"three", ".ktx2", {"rock_normal.ktx2", "rock_orm.ktx2"}}};
  for (const auto& one : engines) {
    SCOPED_TRACE(one.engine);
    const std::string output = std::string(one.engine) + "/rock" + one.extension;
    const ProgramResult result = run_with_maps(output, {"--for", one.engine});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    EXPECT_EQ(files_in(one.engine), one.files);
    EXPECT_EQ(result.out.find("known not to load"), std::string::npos) << result.out;
  }
  const float y = texel("unity/rock_Normal.dds", TexelFormat::kRgba8)[1];
  EXPECT_GT(std::abs(y - 0.5f), 0.02f) << "the map is too flat to show the difference";
  for (const char* file : {"unreal/T_rock_N.dds", "o3de/rock_normal.dds"})
    EXPECT_NEAR(texel(file, TexelFormat::kRgba8)[1], 1.0f - y, 1e-6f) << file << " has green up";
  EXPECT_NEAR(texel("godot/rock_normal.dds", TexelFormat::kBc5)[1], y, 0.06f);
  const std::vector<float> orm = texel("unreal/T_rock_ORM.dds", TexelFormat::kRgba8),
                           mask = texel("unity-hdrp/rock_MaskMap.dds", TexelFormat::kRgba8);
  EXPECT_NEAR(orm[0], 0.25f, 3e-3f);
  EXPECT_NEAR(orm[1], 0.3f + 0.4f * 3.0f / kSide, 3e-3f);
  EXPECT_NEAR(orm[2], 0.75f, 3e-3f);
  EXPECT_NEAR(mask[0], orm[2], 1e-6f);
  EXPECT_NEAR(mask[1], orm[0], 1e-6f);
  EXPECT_EQ(mask[2], 1.0f);
  EXPECT_NEAR(mask[3], 1.0f - orm[1], 1e-6f);
  EXPECT_NEAR(texel("o3de/rock_roughness.dds", TexelFormat::kR8)[0], orm[1], 1e-6f);
  EXPECT_NEAR(texel("o3de/rock_metallic.dds", TexelFormat::kR8)[0], orm[2], 1e-6f);
  EXPECT_NEAR(texel("o3de/rock_ao.dds", TexelFormat::kR8)[0], orm[0], 1e-6f);
  // Blender's textures are images, one per level. Maps that were not given are not written.
  ASSERT_EQ(run("blender", {"--for", "blender"}).exit_code, 0);
  const std::set<std::string> images = files_in("blender");
  EXPECT_EQ(images.size(), 2u * 6);
  EXPECT_TRUE(images.contains("normal_00.png") && images.contains("roughness_05.png"));
}

TEST_F(ExportPresetsTest, SaysWhatThePresetIs) {
  expect_says(run("a.dds", {"--for", "unreal"}).out,
              {"for Unreal: green down, roughness in green of orm, no occlusion, no metalness, dds, rgba8",
               "docs/how-to/unreal.md"});
  expect_says(run("b.dds", {"--for", "o3de"}).out, {"O3DE keeps only level 0"});
  expect_says(multum({"export", "--help"}).out, {"\n  unreal ", "\n  unity-hdrp ", "\n  blender "});
  ASSERT_EQ(run("c.dds", {"--for", "unreal", "--report", path("r.json")}).exit_code, 0);
  EXPECT_EQ(nlohmann::json::parse(read_bytes(path("r.json")))["for"], "unreal");
}

TEST_F(ExportPresetsTest, OptionsReplacePartsOfAPreset) {
  ASSERT_EQ(run("a/rock.ktx2", {"--for", "unreal", "--names", "plain", "--packing", "separate", "--write-green", "up",
                                "--texels", "rg8"})
                .exit_code,
            0);
  EXPECT_EQ(files_in("a"), (std::set<std::string>{"rock_normal.ktx2", "rock_roughness.ktx2"}));
  ASSERT_EQ(run("b/rock.ktx2", {"--packing", "separate", "--texels", "rg8"}).exit_code, 0);
  for (const char* file : {"rock_normal.ktx2", "rock_roughness.ktx2"})
    EXPECT_EQ(read_bytes(path(std::string("a/") + file)), read_bytes(path(std::string("b/") + file))) << file;
  // The name of the output replaces the preset's format, and texels that it cannot store.
  const ProgramResult dds = run("c/rock.dds", {"--for", "babylon"});
  EXPECT_EQ(dds.exit_code, 0) << dds.err;
  expect_says(dds.out, {"dds, rgba8", "known not to load", "Babylon.js"});
  // In a folder, the names contain the map's name.
  ASSERT_EQ(run("d", {"--for", "unreal"}).exit_code, 0);
  EXPECT_EQ(files_in("d"), (std::set<std::string>{"T_rock_N.dds", "T_rock_ORM.dds"}));
}

TEST_F(ExportPresetsTest, RefusesSidesThatTheEngineRefuses) {
  write_test_image(path("odd.png"), normal_image(36, 24));
  const ProgramResult refused = run("odd/odd.dds", {"--for", "unreal"}, "odd.png");
  expect_refusal(refused, kInput, {"odd.png", "36 x 24", "powers of 2", "--sides any"});
  EXPECT_FALSE(std::filesystem::exists(path("odd")));
  EXPECT_EQ(run("odd/odd.dds", {"--for", "unreal", "--sides", "any"}, "odd.png").exit_code, 0);
  EXPECT_EQ(run("even/odd.dds", {"--for", "unreal", "--sides", "multiples-of-4"}, "odd.png").exit_code, 0);
  write_test_image(path("odder.png"), normal_image(35, 24));
  expect_refusal(run("odd.ktx2", {"--sides", "multiples-of-4"}, "odder.png"), kInput, {"35 x 24", "multiples of 4"});
}

TEST_F(ExportPresetsTest, ManifestsHaveThem) {
  const auto with = [&](const std::string& keys) {
    write_bytes(path("maps.toml"),
                "[defaults]\nbumpformat = \"normal\"\ngreen = \"up\"\nfor = \"unreal\"\n[[map]]\ninput = "
                "\"rock_normal.png\"\noutput = \"out/rock.dds\"\n" +
                    keys);
    return multum({"export", "--manifest", path("maps.toml"), "--no-measure"});
  };
  ASSERT_EQ(with("").exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(path("out/T_rock_N.dds")));
  const ProgramResult again = with("for = \"unity\"\n");
  ASSERT_EQ(again.exit_code, 0) << again.err;
  EXPECT_TRUE(std::filesystem::exists(path("out/rock_MaskMap.dds"))) << again.out;
  expect_says(with("for = \"unity\"\n").out, {"0 exported, 1 unchanged"});
}

TEST(TextureNames, FollowTheMapsName) {
  const std::pair<const char*, const char*> names[] = {
      {"maps/rock_normal.png", "rock"}, {"T_Rock_N.tga", "Rock"}, {"wall-height.exr", "wall"}, {"plain.png", "plain"},
      {"normal.png", "normal"},         {"_n.png", "_n"},         {"rock.ndf.exr", "rock"},    {"T_N.png", "T"}};
  for (const auto& [file, material] : names) EXPECT_EQ(material_of_file(file), material) << file;
  EXPECT_EQ(texture_name(TextureNames::kPlain, "", TextureRole::kNormal), "normal");
  EXPECT_EQ(texture_name(TextureNames::kUnity, "rock", TextureRole::kMask), "rock_MaskMap");
}

}  // namespace
}  // namespace multum::testing
