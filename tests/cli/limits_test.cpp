// SPDX-License-Identifier: Apache-2.0
// Tests commands for which a resource is too small or missing: disk space during a bake, memory, open files, a writable
// folder, or the length of names. The error message is clear, and the exit code matches the fault. No signal terminates
// the program, and no half-written file is left.
#include <sys/mount.h>

#include "host/foundation/base/processes/sanitizers.h"
#include "tests/cli/program.h"
#include "tests/unit/formats/image/image_test_files.h"

namespace multum::testing {
namespace {

class LimitsTest : public CliTest {
 protected:
  void SetUp() override {
    make_map("map", 256);
    std::filesystem::create_directory(path("out"));
  }
  std::vector<std::string> bake(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {
        "bake", path("map_normal.png"), "-o", path("out/map.ndf.exr"), "--no-measure", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return multum_command(arguments);
  }
  // Runs a command under a limit that bash's ulimit sets, such as "-f 16".
  static ProgramResult limited(const std::string& limit, const std::vector<std::string>& command) {
    std::vector<std::string> shell = {"bash", "-c", "ulimit " + limit + "; exec \"$@\"", "bash"};
    shell.insert(shell.end(), command.begin(), command.end());
    return run_program(shell);
  }
  // Builds the kernels beforehand: compilers write files too, and PoCL compiles whenever a program is not cached.
  void build_kernels() const {
    const ProgramResult built = run_program(bake());
    ASSERT_EQ(built.exit_code, 0) << built.err;
    std::filesystem::remove(path("out/map.ndf.exr"));
  }
  void expect_failed(const ProgramResult& result, const std::vector<std::string>& parts) const {
    EXPECT_EQ(result.signal, 0);
    EXPECT_GT(result.exit_code, 0);
    expect_says(result.err, parts);
    EXPECT_TRUE(std::filesystem::is_empty(path("out"))) << "something was left";
  }
};

// Limits the size of files to a size that the memory shared with the decoder (771 KiB) just fits. The system then
// reports "File too large"; a full disk would say "No space left on device".
TEST_F(LimitsTest, FilesThatCannotGrow) {
  build_kernels();
  for (const int kibibytes : {780, 800, 820}) {
    SCOPED_TRACE(std::to_string(kibibytes) + " KiB");
    expect_failed(limited("-f " + std::to_string(kibibytes), bake()), {path("out"), "File too large"});
  }
}

TEST_F(LimitsTest, PicturesThatCannotGrow) {
  const ProgramResult result = limited("-f 16", multum_command({"testmap", path("out/picture"), "--size", "256"}));
  expect_failed(result, {path("out/picture"), ".png: writing failed: File too large"});
}

// The memory shared with the decoding child counts as a file.
TEST_F(LimitsTest, SharedMemoryThatCannotGrow) {
  expect_failed(limited("-f 16", bake()), {"shared memory of", "File too large", "ulimit -f"});
}

TEST_F(LimitsTest, ADiskThatIsFull) {
  if (mount("tmpfs", path("out").c_str(), "tmpfs", 0, "size=600k") != 0)
    GTEST_SKIP() << "no file system can be mounted";
  const ProgramResult result = run_program(bake());
  expect_failed(result, {path("out"), "No space left on device"});
  umount(path("out").c_str());
}

TEST_F(LimitsTest, TooLittleMemoryNamesWhatIsNeeded) {
  expect_failed(run_program(bake({"--memory", "100M"})), {"--memory", "100 MiB", "at least 288 MiB"});
  expect_failed(run_program(bake({"--memory", "much"})), {"--memory", "much"});
  // The memory for the windows is known when the map has been read. One refusal states all that is missing.
  make_map("map", 2048);
  const ProgramResult refused = run_program(bake({"--memory", "288M"}));
  const std::string words = "; add at least ";
  expect_failed(refused, {"--memory leaves 8.0 MiB", words});
  const std::size_t at = refused.err.find(words);
  ASSERT_NE(at, std::string::npos);
  const int missing = std::stoi(refused.err.substr(at + words.size()));
  const ProgramResult enough = run_program(bake({"--memory", std::to_string(288 + missing) + "M"}));
  EXPECT_EQ(enough.exit_code, 0) << enough.err;
}

// Every command refuses a name that is too long for a file before it starts to work. Such a name counts as a bad input,
// because no other machine would accept it either.
TEST_F(LimitsTest, NamesThatAreTooLongAreOfTheCommandLine) {
  const std::string name(256, 'x');
  std::string deep;
  while (deep.size() < 4096) deep += "folder/";
  std::vector<std::vector<std::string>> commands = {
      {"bake", path("map_normal.png"), "-o", path("out/" + name + ".ndf.exr")},
      {"bake", path(name + ".png"), "-o", path("out/map.ndf.exr")},
      {"bake", path("map_normal.png"), "-o", path("out/map.ndf.exr"), "--report=" + path(name)},
      {"export", path("map_normal.png"), "-o", path("out/" + deep + "a")},
      {"mip", path("map_albedo.png"), "-o", path("out/" + name + ".exr")},
      {"info", path(name)},
      {"verify", name},
      {"testmap", path("out/" + name)},
      {"plan", path(name + ".toml")}};
  if (has_command("serve")) commands.push_back({"serve", "--data", path(name)});
  for (const std::vector<std::string>& command : commands) {
    SCOPED_TRACE(command.front());
    const ProgramResult result = multum(command);
    EXPECT_EQ(result.exit_code, kUsage) << result.err;
    expect_says(result.err, {"too long", "bytes", "expected at most"});
    EXPECT_TRUE(std::filesystem::is_empty(path("out")));
  }
  const std::string view = std::string(MULTUM_BIN_DIR) + "/multum-view";
  if (std::filesystem::exists(view)) {
    EXPECT_EQ(run_program({view, path(name), "-o", path("a.png")}).exit_code, kUsage);
  }
  const std::string longest = path("out/" + std::string(251, 'x') + ".png");
  EXPECT_EQ(multum({"info", longest}).exit_code, kInput) << "this folder does not exist, but a file could";
}

// In this home folder, nobody can create PoCL's cache or multum's program cache, not even root.
TEST_F(LimitsTest, KernelsThatCannotBeKeptAreCompiledInAPrivateFolder) {
  std::filesystem::create_directory(path("tmp"));
  std::vector<std::string> command = {"env",
                                      "-u",
                                      "MULTUM_CACHE_DIR",
                                      "-u",
                                      "POCL_CACHE_DIR",
                                      "-u",
                                      "XDG_CACHE_HOME",
                                      "HOME=" + path("map_normal.png"),
                                      "TMPDIR=" + path("tmp")};
  for (const std::string& word : multum_command({"devices"})) command.push_back(word);
  const ProgramResult result = run_program(command);
  EXPECT_EQ(result.exit_code, 0) << result.err;
  expect_says(result.err, {path("map_normal.png/.cache/multum"), "Not a directory", "MULTUM_CACHE_DIR",
                           path("map_normal.png/.cache/pocl/kcache"), "POCL_CACHE_DIR"});
  EXPECT_TRUE(std::filesystem::is_empty(path("tmp"))) << "the private folder is removed with the program";
}

#ifndef MULTUM_SHADOW_MEMORY  // the sanitizer reserves terabytes
// The file is not at fault, because another machine may be able to read it. OpenImageIO needs more memory than the
// libraries of PNG and JPEG.
TEST_F(LimitsTest, TooLittleMemoryToDecodeIsOfTheMachine) {
  write_test_image(path("map.tif"), normal_image(256, 256));
  for (const char* limit : {"-v 200000", "-v 330000", "-d 20000", "-d 100000"}) {
    SCOPED_TRACE(limit);
    const ProgramResult result = limited(limit, multum_command({"mip", path("map.tif"), "-o", path("out/a.exr")}));
    EXPECT_EQ(result.signal, 0);
    EXPECT_EQ(result.exit_code, kEnvironment) << result.err;
    expect_says(result.err, {"memory"});
  }
}
#endif

TEST_F(LimitsTest, ScratchMustBeAFolder) {
  expect_failed(run_program(bake({"--scratch", path("none"), "--memory", "300M"})), {path("none")});
}

}  // namespace
}  // namespace multum::testing
