// SPDX-License-Identifier: Apache-2.0
// Bakes that run out of something: disk in mid-bake, memory, a folder to write to. A clear error, an exit code, and
// nothing half-written.
#include <sys/mount.h>

#include "tests/cli/program.h"

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
  // Compilers write files too, PoCL whenever a program is not in a file.
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

// Files may not grow beyond a limit that the memory shared with the decoder just keeps (771 KiB), which says "File too
// large" where a full disk says "No space left on device".
TEST_F(LimitsTest, FilesThatCannotGrow) {
  build_kernels();
  for (const int kibibytes : {780, 800, 820}) {
    SCOPED_TRACE(std::to_string(kibibytes) + " KiB");
    std::vector<std::string> shell = {"bash", "-c",
                                      "trap '' XFSZ; ulimit -f " + std::to_string(kibibytes) + "; exec \"$@\"", "bash"};
    for (const std::string& word : bake()) shell.push_back(word);
    expect_failed(run_program(shell), {path("out"), "File too large"});
  }
}

TEST_F(LimitsTest, PicturesThatCannotGrow) {
  const ProgramResult result =
      run_program({"bash", "-c", "trap '' XFSZ; ulimit -f 16; exec \"$@\"", "bash",
                   std::string(MULTUM_BIN_DIR) + "/multum", "testmap", path("out/picture"), "--size", "256"});
  expect_failed(result, {path("out/picture"), ".png: writing failed: File too large"});
}

// The memory that the decoding child shares counts as a file.
TEST_F(LimitsTest, SharedMemoryThatCannotGrow) {
  std::vector<std::string> shell = {"bash", "-c", "trap '' XFSZ; ulimit -f 16; exec \"$@\"", "bash"};
  for (const std::string& word : bake()) shell.push_back(word);
  expect_failed(run_program(shell), {"shared memory of", "File too large", "ulimit -f"});
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
}

TEST_F(LimitsTest, ScratchMustBeAFolder) {
  expect_failed(run_program(bake({"--scratch", path("none"), "--memory", "300M"})), {path("none")});
}

}  // namespace
}  // namespace multum::testing
