// SPDX-License-Identifier: Apache-2.0
// When the decoding child fails, the command reports either a bad file or a fault of the machine, with the matching
// exit code. An older output stays unchanged.
#include "host/foundation/base/processes/sanitizers.h"
#include "tests/cli/program.h"
#include "tests/unit/fields/inference/animation_test_scene.h"

namespace multum::testing {
namespace {

namespace fs = std::filesystem;

class DecodingFailureTest : public CliTest {
 protected:
  static constexpr const char* kModule = "multum-decode-libraries.so";

  // Installs the programs in a folder of their own. There, failing_helper replaces multum-decode and fails in the way
  // that its file name says (tests/unit/foundation/sandbox/failing_helper.cpp). If `decoder` is empty, multum-decode is
  // missing.
  void install(const std::string& decoder) {
    fs::remove_all(path("bin"));
    fs::create_directories(path("bin"));
    const fs::path built = MULTUM_BIN_DIR;
    for (const char* program : {"multum", "multum-view"}) fs::copy_file(built / program, path("bin/") + program);
    if (!decoder.empty()) fs::copy_file(built / decoder, path("bin/multum-decode"));
    fs::copy_file(built / kModule, path("bin/") + kModule);
    make_map("map", 16);
    fs::create_directory(path("out"));
  }

  // Runs `command` with an older file as the argument of -o.
  ProgramResult expect_refused(std::vector<std::string> command, int code,
                               const std::vector<std::string>& parts) const {
    const std::string output = path("out/") + (command.front() == "multum" ? "map.ndf.exr" : "picture.png");
    command.front() = path("bin/") + command.front();
    command.insert(command.end(), {"-o", output});
    write_bytes(output, "an older file");
    const ProgramResult result = run_program(command);
    expect_refusal(result, code, parts);
    EXPECT_EQ(std::distance(fs::directory_iterator(path("out")), {}), 1) << "a file is left in the folder";
    EXPECT_EQ(read_bytes(output), "an older file");
    fs::remove(output);
    return result;
  }

  std::string map_named(const std::string& name) const {
    fs::copy_file(path("map_normal.png"), path(name), fs::copy_options::overwrite_existing);
    return path(name);
  }
};

TEST_F(DecodingFailureTest, BakeRefusesWhatEndsItsDecoder) {
  install("failing_helper");
#ifndef MULTUM_SHADOW_MEMORY  // the sanitizer prints its own messages for signals
  expect_refused({"multum", "bake", map_named("segfault.png")}, kInput,
                 {"segfault.png: ", "decoding", "signal 11", "Segmentation fault", "expected"});
#endif
  expect_refused({"multum", "bake", map_named("exit.png")}, kInput, {"exit.png: ", "decoding", "exit code 7"});
  expect_refused({"multum", "bake", map_named("hang.png"), "--decode", "child:1"}, kInput,
                 {"hang.png: ", "decoding", "more than 1 s"});
}

TEST_F(DecodingFailureTest, NoDecoderIsAnErrorOfTheMachine) {
  install("");
  expect_refused({"multum", "bake", path("map_normal.png")}, kEnvironment,
                 {"bin/multum-decode: ", "started", "No such file or directory"});
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", path("map.ndf.exr"), "-q", "--no-measure"}).exit_code, 0);
  write_bytes(path("mesh.obj"), "");
  expect_refused({"multum-view", path("map.ndf.exr"), "--mesh", path("mesh.obj")}, kEnvironment,
                 {"bin/multum-decode: ", "started"});
  install("multum-decode");
  fs::remove(path("bin/") + kModule);
  expect_refused({"multum-view", path("map.ndf.exr"), "--mesh", path("mesh.obj")}, kEnvironment,
                 {kModule, "not found", "install"});
  EXPECT_EQ(run_program({path("bin/multum"), "bake", path("map_normal.png"), "-o", path("a.ndf.exr"), "-q"}).exit_code,
            0)
      << "PNG needs no module";
}

// Without a decoder, no file can be read. With a decoder, the decoder's memory limit is passed on to the multum-view
// that the sweep starts.
TEST_F(DecodingFailureTest, SweepsAndPlansReadByTheDecoder) {
  install("");
  write_bytes(path("scene.toml"),
              "[[map]]\nname = \"wall\"\nnormal = \"map_normal.png\"\n[[material]]\nname = \"paint\"\nbrdf = "
              "\"lambert\"\n[[object]]\nname = \"wall\"\nmap = \"wall\"\nmaterial = \"paint\"\nwidth = 1\n"
              "distance = [1, 2]\n[[light]]\ndirection = [0, 0, 1]\n");
  const std::string multum = path("bin/multum");
  EXPECT_EQ(run_program({multum, "plan", path("scene.toml")}).exit_code, kEnvironment);
  install("multum-decode");
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{multum, "plan", path("scene.toml"), "--decode", "child:60"},
        {multum, "tradeoff", path("map_normal.png"), "-o", path("page.html"), "--quick", "--decode", "child:60,2G"}}) {
    const ProgramResult result = run_program(command);
    EXPECT_EQ(result.exit_code, 0) << result.err;
  }
  EXPECT_NE(read_bytes(path("page.html")).find("data:image/png"), std::string::npos);
}

TEST_F(DecodingFailureTest, TheViewerRefusesWhatEndsItsDecoder) {
  install("failing_helper");
  const std::string baked = path("map.ndf.exr");
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", baked, "-q", "--no-measure"}).exit_code, 0);
  write_bytes(path("exit.obj"), "");
  write_bytes(path("hang.glb"), "");
  expect_refused({"multum-view", baked, "--mesh", path("exit.obj")}, kInput,
                 {"exit.obj: ", "decoding", "exit code 7", "assimp"});
  expect_refused({"multum-view", baked, "--mesh", path("hang.glb"), "--decode", "child:1"}, kInput,
                 {"hang.glb: ", "decoding", "more than 1 s"});
  expect_refused({"multum-view", baked, "--source", map_named("exit.png"), "--compare", "reference"}, kInput,
                 {"exit.png: ", "decoding", "exit code 7"});
}

#ifndef MULTUM_SHADOW_MEMORY
TEST_F(DecodingFailureTest, MeshesThatNeedTooMuchMemoryAreRefused) {
  install("multum-decode");
  const std::string baked = path("map.ndf.exr");
  ASSERT_EQ(multum({"bake", path("map_normal.png"), "-o", baked, "-q", "--no-measure"}).exit_code, 0);
  write_bytes(path("bomb.gltf"), gltf_bomb());
  const std::vector<std::string> parts = {"bomb.gltf: ", "decoding", "bytes of memory",
                                          "--decode child:SECONDS,MEMORY"};
  std::vector<std::string> command = {"multum-view", baked, "--mesh", path("bomb.gltf")};
  const ProgramResult usual = expect_refused(command, kInput, parts);
  EXPECT_TRUE(contains(usual.err, " 1073")) << usual.err;  // The file is a little larger than 2^30 bytes.
  command.insert(command.end(), {"--decode", "child:30,128M"});
  const ProgramResult less = expect_refused(command, kInput, parts);
  EXPECT_TRUE(contains(less.err, " 134")) << less.err;
}
#endif

TEST_F(DecodingFailureTest, WhereFilesAreDecodedIsChecked) {
  make_map("map", 16);
  for (const char* place :
       {"there", "here", "child:0", "child:2x", "child:2,", "child:2,much", "child:2,1M", "child:,1G"}) {
    const ProgramResult result = multum({"bake", path("map_normal.png"), "-o", path("a.exr"), "--decode", place});
    SCOPED_TRACE(place);
    expect_refusal(result, kUsage, {"child,", "child:SECONDS", "1 to 86400", "child:SECONDS,MEMORY"});
  }
  EXPECT_NE(multum({"tradeoff", "--help"}).out.find("--decode"), std::string::npos);
}

}  // namespace
}  // namespace multum::testing
