// SPDX-License-Identifier: Apache-2.0
// Files with names that are not UTF-8 are baked and reported. multum never writes a file whose name has control
// characters. Every command refuses files that are not regular files at once, because a program that waited for their
// data might never end.
#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "host/foundation/base/path_text.h"
#include "tests/cli/program.h"

namespace multum::testing {
namespace {

using Json = nlohmann::json;

class SpecialNamesTest : public CliTest {
 protected:
  SpecialNamesTest() { make_map("map", 16); }
  Json report() const { return Json::parse(read_bytes(path("report.json"))); }
  void expect_success(const std::vector<std::string>& arguments) {
    const ProgramResult result = multum(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
};

TEST_F(SpecialNamesTest, NamesThatAreNotUtf8AreReported) {
  for (const std::string& name : {std::string("n\xff.png"), std::string("\xc3.png"), std::string("\uefff.png")}) {
    const std::string input = path(name), output = path(name + ".ndf.exr");
    std::filesystem::copy_file(path("map_normal.png"), input);
    expect_success({"bake", input, "-o", output, "--ndf", "moments", "--no-measure", "--report", path("report.json")});
    EXPECT_EQ(path_of_text(report()["source"].get<std::string>()), name);
    expect_success({"verify", output});
    expect_success({"mip", input, "-o", path("mip.exr"), "--report", path("report.json"), "--force"});
    expect_success(
        {"export", input, "-o", path("o" + name + ".ktx2"), "--no-measure", "--report", path("report.json")});
  }
}

TEST_F(SpecialNamesTest, ManifestsNameThemByTheSameEscape) {
  std::filesystem::copy_file(path("map_normal.png"), path("n\xff.png"));
  write_bytes(path("maps.toml"), "[[map]]\ninput = \"" + text_of_path("n\xff.png") + "\"\noutput = \"" +
                                     text_of_path("o\xff.ndf.exr") + "\"\nndf = \"moments\"\n");
  expect_success({"bake", "--manifest", path("maps.toml"), "--junit", path("report.xml")});
  EXPECT_TRUE(std::filesystem::is_regular_file(path("o\xff.ndf.exr")));
  EXPECT_NE(read_bytes(path("report.xml")).find(text_of_path("o\xff.ndf.exr")), std::string::npos);
}

TEST_F(SpecialNamesTest, OutputsWithControlCharactersAreRefused) {
  const std::string map = path("map_normal.png");
  for (const char* name : {"a\nb.ndf.exr", "\x1b]0;title\x07.exr", "a\xc2\x9b.exr"})
    expect_refusal(multum({"bake", map, "-o", path(name), "--ndf", "moments"}), kUsage, {"control character"});
  expect_refusal(multum({"bake", map, "-o", path("a.ndf.exr"), "--report", path("a\n.json")}), kUsage, {"control"});
  expect_refusal(multum({"mip", map, "-o", path("a\x7f.exr")}), kUsage, {"control character"});
  expect_refusal(multum({"export", map, "-o", path("a\tb")}), kUsage, {"control character"});
  expect_refusal(multum({"testmap", path("a\nb.png")}), kUsage, {"control character"});
  EXPECT_EQ(folder_.names(), (Names{"map_albedo.png", "map_normal.png"}));
}

TEST_F(SpecialNamesTest, WhatIsNoFileIsRefusedByEveryCommand) {
  for (const char* name : {"a.exr", "a.ktx2", "a.glb", "a.toml", "a.json", "a.mpt", "a.obj", "a.hdr"})
    ASSERT_EQ(::mkfifo(path(name).c_str(), 0600), 0);
  const std::string map = path("map_normal.png"), exr = path("a.exr"), out = path("out.ndf.exr");
  const std::vector<std::vector<std::string>> commands = {
      {"bake", exr, "-o", out},
      {"bake", map, "-o", out, "--albedo", exr},
      {"bake", map, "-o", out, "--roughness", exr},
      {"bake", map, "-o", out, "--gloss", exr},
      {"bake", map, "-o", out, "--weights", exr},
      {"bake", "--manifest", path("a.toml")},
      {"bake", path("a.toml"), "-o", path("out")},
      {"export", exr, "-o", path("out.ktx2")},
      {"export", map, "-o", path("out.ktx2"), "--roughness", exr},
      {"gltf", path("a.glb"), "-o", path("out.glb")},
      {"materials", path("a.glb")},
      {"infer", path("a.toml"), "-o", path("out")},
      {"info", exr},
      {"info", path("a.ktx2")},
      {"info", path("a.mpt")},
      {"verify", exr},
      {"verify", path("a.mpt")},
      {"look", exr, "-o", path("out.html")},
      {"mip", exr, "-o", out},
      {"reflectance", "-o", out, "--environment", path("a.hdr")},
      {"unpack", path("a.mpt"), "-o", path("out")},
      {"player", path("a.mpt"), "-o", path("out")},
      {"tradeoff", exr, "-o", path("out.html")},
  };
  for (const std::vector<std::string>& command : commands) {
    const ProgramResult result = multum(command);
    EXPECT_EQ(result.exit_code, kInput) << command[0] << ' ' << command[1] << '\n' << result.err;
    EXPECT_NE(result.err.find("a FIFO, expected a regular file"), std::string::npos) << result.err;
  }
}

}  // namespace
}  // namespace multum::testing
