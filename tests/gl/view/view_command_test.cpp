// SPDX-License-Identifier: Apache-2.0
// Tests the subcommands of multum-view: the help of each subcommand, the old options that still select them, and
// refusals. pyramid_view_test.cpp and inferred_view_test.cpp test pyramids and texture inference.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "host/foundation/base/processes/child_process.h"
#include "tests/gl/test_maps.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

class ViewCommandTest : public ::testing::Test {
 protected:
  ViewCommandTest() {
    write_movmf_mipmap(path("map.ndf.exr"), gl::make_two_tilt_map(16, 20.0, StorageEncoding::kSnorm16, false).mipmap,
                       {});
  }
  std::string path(const std::string& name) const { return folder_ / name; }
  static ChildResult run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), std::string(MULTUM_BIN_DIR) + "/multum-view");
    return run_child(arguments);
  }
  /// Draws a picture into the file `name` with the command, and returns the bytes of the file.
  std::string drawn(const std::string& name, std::vector<std::string> arguments) const {
    std::filesystem::remove(path(name));
    arguments.insert(arguments.end(), {"--context", "osmesa"});
    const ChildResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    return std::filesystem::exists(path(name)) ? testing::read_bytes(path(name)) : "";
  }
  void expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& parts) const {
    const std::set<std::string> before = folder_.names();
    const ChildResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 2) << result.output;
    testing::expect_says(result.output, parts);
    EXPECT_EQ(folder_.names(), before);
  }
  /// Writes the bake of a scene in which two objects share one map.
  void write_plan() const {
    nlohmann::json view = {{"file", "map.ndf.exr"},
                           {"size", "32x24"},
                           {"camera", "0,0,2,0,3,0,50"},
                           {"repeat", 7.5},
                           {"brdf", {"ggx:0.4,0.04,0.04,0.04"}},
                           {"diffuse", {"0.2,0.3,0.4"}},
                           {"specular", {"1,1,1"}},
                           {"fixed-fresnel", "0.1,0.1,0.1"},
                           {"light", {"0.3,0.8,0.5,2"}},
                           {"point_light", {"0,2,1,3,2,1"}}};
    nlohmann::json plan;
    plan["objects"].push_back({{"name", "wall"}, {"view", view}});
    view["light"] = {"0,0,1,2"};
    plan["objects"].push_back({{"name", "floor"}, {"view", view}});
    testing::write_bytes(path("plan.json"), plan.dump());
  }
  testing::TemporaryFolder folder_;
};

const std::vector<std::string> kObjectAsOptions = {
    "--size",          "32x24",       "--camera",   "0,0,2,0,3,0,50",
    "--repeat",        "7.5",         "--brdf",     "ggx:0.4,0.04,0.04,0.04",
    "--diffuse",       "0.2,0.3,0.4", "--specular", "1,1,1",
    "--fixed-fresnel", "0.1,0.1,0.1", "--light",    "0.3,0.8,0.5,2",
    "--point-light",   "0,2,1,3,2,1"};

// A stored reference equals the reference that would be drawn. Other files are refused.
TEST_F(ViewCommandTest, AReferenceIsKept) {
  const auto compared = [&](std::vector<std::string> more, int code) {
    more.insert(more.begin(), {path("map.ndf.exr"), "-o", path("out.png"), "--compare", "reference", "--samples", "4",
                               "--report", path("out.json"), "--context", "osmesa"});
    const ChildResult result = run(more);
    EXPECT_EQ(result.exit_code, code) << result.output;
    return code == 0 ? nlohmann::json::parse(testing::read_bytes(path("out.json")))["pictures"][1]["relative_l1"]
                     : nlohmann::json(result.output);
  };
  const std::vector<std::string> small = {"--size", "32x24"}, kept = {"--size", "32x24", "--keep-reference", path("r")};
  const nlohmann::json drawn = compared(small, 0);
  EXPECT_EQ(compared(kept, 0), drawn);
  const std::string bytes = testing::read_bytes(path("r"));
  EXPECT_EQ(bytes.size(), 8u + 32u + 32u * 24u * 16u);
  EXPECT_EQ(compared(kept, 0), drawn);
  // A different stored reference changes the error. This shows that the file is really used.
  std::string other = bytes;
  std::fill(other.begin() + 40, other.end(), '\0');
  testing::write_bytes(path("r"), other);
  EXPECT_NE(compared(kept, 0), drawn);
  for (const std::string& broken : {std::string("no reference"), bytes.substr(0, bytes.size() - 1), bytes + "x"}) {
    testing::write_bytes(path("r"), broken);
    testing::expect_says(compared(kept, 3).get<std::string>(), {"expected a reference of 32 x 24", "remove the file"});
  }
  testing::write_bytes(path("r"), bytes);
  testing::expect_says(compared({"--size", "24x24", "--keep-reference", path("r")}, 3).get<std::string>(),
                       {"32 x 24", "24 x 24"});
  testing::expect_says(compared({"--reference-of", "texels", "--keep-reference", path("r")}, 2).get<std::string>(),
                       {"--keep-reference"});
  EXPECT_EQ(testing::read_bytes(path("r")), bytes);
}

// The picture equals the picture that is drawn without a comparison, and the errors of the comparison do not change.
TEST_F(ViewCommandTest, AMapIsComparedAndShownAlone) {
  const auto drawn = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {path("map.ndf.exr"), "-o", path("out.png"), "--report", path("out.json"), "--context",
                               "osmesa", "--size", "32x24"});
    const ChildResult result = run(more);
    EXPECT_EQ(result.exit_code, 0) << result.output;
    const nlohmann::json report = nlohmann::json::parse(testing::read_bytes(path("out.json")));
    EXPECT_EQ(report["context_is_software"], true);
    const nlohmann::json& own = report["pictures"].back();
    EXPECT_GT(own["frame_processor_ms"].get<double>(), 0.0) << own;
    return std::pair(testing::read_bytes(path("out.png")), own.value("relative_l1", 0.0));
  };
  const std::vector<std::string> compare = {"--compare", "reference", "--samples", "4"};
  std::vector<std::string> alone = compare;
  alone.push_back("--alone");
  const auto by_itself = drawn({}), sheet = drawn(compare), shown = drawn(alone);
  EXPECT_EQ(shown.first, by_itself.first);
  EXPECT_NE(sheet.first, by_itself.first);
  EXPECT_EQ(shown.second, sheet.second);
  EXPECT_GT(shown.second, 0.0);
}

// Command lines from a file give the same results as single commands, up to the first command that fails.
TEST_F(ViewCommandTest, CommandLinesOfAFileAreRunInOneProcess) {
  const auto line = [&](const std::string& picture, const std::string& size) {
    return std::vector<std::string>{path("map.ndf.exr"), "-o", path(picture), "--context", "osmesa", "--size", size};
  };
  const auto run_lines = [&](const nlohmann::json& lines) {
    testing::write_bytes(path("views.json"), lines.dump());
    return run({"each", path("views.json")});
  };
  ASSERT_EQ(run(line("alone.png", "32x24")).exit_code, 0);
  const ChildResult both = run_lines({line("a.png", "24x32"), line("b.png", "32x24")});
  ASSERT_EQ(both.exit_code, 0) << both.output;
  EXPECT_EQ(testing::read_bytes(path("b.png")), testing::read_bytes(path("alone.png")));
  EXPECT_NE(testing::read_bytes(path("a.png")), testing::read_bytes(path("alone.png")));
  const ChildResult failed =
      run_lines({line("c.png", "32x24"), {path("none.ndf.exr"), "-o", "x.png"}, line("d.png", "32x24")});
  EXPECT_EQ(failed.exit_code, 3);
  testing::expect_says(failed.output, {"none.ndf.exr"});
  EXPECT_TRUE(std::filesystem::exists(path("c.png")));
  EXPECT_FALSE(std::filesystem::exists(path("d.png")));
  for (const nlohmann::json& broken : {nlohmann::json(3), nlohmann::json{{"-o", 3}}, nlohmann::json{"map.ndf.exr"},
                                       nlohmann::json{{"each", "views.json"}}}) {
    const ChildResult refused = run_lines(broken);
    EXPECT_EQ(refused.exit_code, 3) << broken;
    testing::expect_says(refused.output, {"views.json", "expected"});
  }
}

TEST_F(ViewCommandTest, EverySubcommandHasItsOwnHelp) {
  const std::map<std::string, std::vector<std::string>> parts = {
      {"scene", {"Draw an object", "--object", "--output", "--brdf", "plan.json"}},
      {"animate", {"Draw frames", "--to-camera", "--frames", "--scene"}},
#ifdef MULTUM_HAS_FIELDS
      {"sample", {"Draw samples", "--at", "--exposure"}},
      {"play", {"Draw frames along", "--path", "--no-wait", "a..b"}},
      {"probe", {"Measure the weights", "--matrix-market", "--threads"}},
#endif
      {"pyramid", {"Draw a surface", "--lookup", "--shifts", "--mesh"}},
      {"lod", {"Draw one level of a pyramid of heights", "--level"}},
      {"model", {"Draw a glTF model", "--material", "--distance"}},
      {"thumbnails", {"Draw small pictures", "--source", "--albedo"}},
      {"each", {"Run several command lines", "views.json"}}};
  const ChildResult all = run({"--help"});
  ASSERT_EQ(all.exit_code, 0);
  for (const auto& [command, said] : parts) {
    SCOPED_TRACE(command);
    const ChildResult help = run({command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    testing::expect_says(help.output, said);
    testing::expect_says(help.output, {"Usage: multum-view " + command, "multum-view " + command + " "});
    EXPECT_NE(all.output.find("\n  " + command + " "), std::string::npos);
  }
}

// Returns a triangle with one material. `extension` is the glTF text of the material's "extensions".
std::string model_of_material(const std::string& extension) {
  return R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
         R"("meshes":[{"primitives":[{"attributes":{"POSITION":0,"TEXCOORD_0":1},"material":0}]}],)"
         R"("accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},)"
         R"({"bufferView":0,"componentType":5126,"count":3,"type":"VEC2"}],)"
         R"("bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:;base64,)"
         R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}],)"
         R"("materials":[{"name":"brushed","extensions":{)" +
         extension + "}}]}";
}

TEST_F(ViewCommandTest, ModelsOfAnisotropicMaterialsAreRefused) {
  const auto draw = [&](const std::string& extension) {
    testing::write_bytes(path("model.gltf"), model_of_material(extension));
    return run({"model", path("model.gltf"), "-o", path("a.png"), "--size", "16x12"});
  };
  const ChildResult refused = draw(R"("KHR_materials_anisotropy":{"anisotropyStrength":0.5})");
  EXPECT_EQ(refused.exit_code, exit_code(ErrorCode::kInput));
  testing::expect_says(refused.output, {"model.gltf", "brushed", "KHR_materials_anisotropy", "0.5", "--brdf"});
  for (const char* extension : {"", R"("KHR_materials_anisotropy":{"anisotropyRotation":1})"}) {
    const ChildResult drawn = draw(extension);
    EXPECT_EQ(drawn.exit_code, 0) << drawn.output;
  }
}

TEST_F(ViewCommandTest, APlanIsDrawnAsItsOptionsAre) {
  write_plan();
  const std::string picture = path("a.exr");
  std::vector<std::string> plain = {path("map.ndf.exr"), "-o", picture};
  plain.insert(plain.end(), kObjectAsOptions.begin(), kObjectAsOptions.end());
  const std::string expected = drawn("a.exr", plain);
  ASSERT_FALSE(expected.empty());
  EXPECT_EQ(drawn("a.exr", {"scene", path("plan.json"), "--object", "wall", "-o", picture}), expected);
  EXPECT_EQ(drawn("a.exr", {"scene", path("plan.json"), "--object=floor", "--light", "0.3,0.8,0.5,2", "-o", picture}),
            expected)
      << "options replace the plan's values";
  EXPECT_NE(drawn("a.exr", {"scene", path("plan.json"), "--object=floor", "-o", picture}), expected);
}

TEST_F(ViewCommandTest, MixedModesAreRefused) {
  write_plan();
  const std::string map = path("map.ndf.exr"), plan = path("plan.json"), out = path("out.png");
  expect_refusal({map, "--scene", plan, "-o", out}, {"unknown option '--scene'", "'multum-view animate'"});
  expect_refusal({map, "-o", out, "--frames=3"}, {"unknown option '--frames'", "'multum-view animate'"});
  expect_refusal({map, "-o", out, "-o", path("b.png")}, {"--output"});
  expect_refusal({map}, {"--output", "required"});
  expect_refusal({"--size", "8x8", "scene", plan, "-o", out}, {"--size", "before 'scene'"});
  expect_refusal({map, "scene", plan, "-o", out}, {"map.ndf.exr", "before 'scene'"});
  expect_refusal({"scene", plan, map, "-o", out}, {"multum-view scene", "not expected", "map.ndf.exr"});
  expect_refusal({"animate", "-o", path("f"), "--to-diffuse", "1"}, {"no file", "--scene"});
}

TEST_F(ViewCommandTest, MisspeltNamesAreSuggested) {
  const std::string out = path("out.png");
  expect_refusal({"scen", "plan.json", "-o", out}, {"unknown subcommand 'scen'", "did you mean 'scene'", "thumbnails"});
  expect_refusal({"modl"}, {"unknown subcommand 'modl'", "did you mean 'model'"});
  expect_refusal({"animated", "-o", out}, {"unknown subcommand 'animated'", "did you mean 'animate'"});
  expect_refusal({path("map.ndf.exr"), "-o", out, "--compar", "mip"}, {"unknown option '--compar'", "'--compare'"});
  expect_refusal({"lod", "out", "--leve=3", "-o", out}, {"multum-view lod: ", "'--leve'", "mean '--level'"});
  expect_refusal({"lod", "a.exr", "-o", out, "--zzzzzzzz"},
                 {"unknown option '--zzzzzzzz'", "'multum-view lod --help'"});
}

}  // namespace
}  // namespace multum
