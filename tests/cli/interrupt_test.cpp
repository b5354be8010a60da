// SPDX-License-Identifier: Apache-2.0
// Tests interrupted bakes. kill -9 leaves at most a hidden temporary file named .multum-tmp-PID-NUMBER-PLACE-NAME, and
// finished rows in .multum-partial-NAME. The next bake of NAME removes both. After SIGINT and SIGTERM no file remains.
#include <signal.h>

#include <chrono>
#include <random>
#include <thread>

#include "tests/cli/program.h"

namespace multum::testing {
namespace {

using Seconds = std::chrono::duration<double>;

double now() { return Seconds(std::chrono::steady_clock::now().time_since_epoch()).count(); }
void pause(double seconds) { std::this_thread::sleep_for(Seconds(seconds)); }

class InterruptTest : public CliTest {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(path("out"));
    make_map("map", 512);
  }
  // The bake takes long enough to be interrupted. The best compression makes writing slow, so even the last stage can
  // be interrupted.
  std::vector<std::string> command() const {
    return multum_command({"bake", path("map_normal.png"), "--albedo", path("map_albedo.png"), "-o",
                           path("out/map.ndf.exr"), "--no-measure", "--compression", "zip:8"});
  }
  std::set<std::string> names() const {
    std::set<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(path("out")))
      found.insert(entry.path().filename().string());
    return found;
  }
  // Waits until the bake has read its map; its signal handlers are installed by then.
  static void wait_until_fitting(Program& bake) {
    while (bake.running() && bake.err_so_far().find("512 x 512") == std::string::npos) pause(0.005);
  }
  // Waits until a large part of the file is written. Returns the temporary file's name.
  std::string wait_until_writing(Program& bake) const {
    while (bake.running()) {
      for (const auto& entry : std::filesystem::directory_iterator(path("out"))) {
        std::error_code gone;
        if (entry.path().filename() != "map.ndf.exr" && entry.file_size(gone) > 200000 && !gone)
          return entry.path().filename().string();
      }
      pause(0.001);
    }
    return "";
  }
};

TEST_F(InterruptTest, Kill9LeavesNothingUnderTheFinalName) {
  ASSERT_EQ(run_program(command()).exit_code, 0);  // this run builds the kernels
  std::filesystem::remove(path("out/map.ndf.exr"));
  const double start = now();
  ASSERT_EQ(run_program(command()).exit_code, 0);
  const double whole = now() - start;
  const std::string finished = read_bytes(path("out/map.ndf.exr"));
  const unsigned seed = std::random_device()();
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  int killed = 0;
  for (int i = 0; i < 6; ++i) {
    std::filesystem::remove(path("out/map.ndf.exr"));
    Program bake(command());
    pause(whole * (i + std::uniform_real_distribution<double>()(random)) / 7.0);
    bake.send(SIGKILL);
    const ProgramResult result = bake.wait();
    if (result.signal == SIGKILL && !std::filesystem::exists(path("out/map.ndf.exr"))) {
      ++killed;
    } else {  // this run was faster than the first one, so the file is complete even after a late kill
      EXPECT_TRUE(result.signal == SIGKILL || result.exit_code == 0) << result.exit_code;
      EXPECT_TRUE(read_bytes(path("out/map.ndf.exr")) == finished) << "kill " << i;
    }
  }
  EXPECT_GE(killed, 3);
  // After the killed runs, the next bake is complete and leaves no other file in its folder.
  ASSERT_EQ(run_program(command()).exit_code, 0);
  EXPECT_TRUE(read_bytes(path("out/map.ndf.exr")) == finished);
  EXPECT_EQ(names(), std::set<std::string>{"map.ndf.exr"});
}

TEST_F(InterruptTest, Kill9WhileWritingLeavesATemporaryFileThatTheNextBakeRemoves) {
  write_bytes(path("out/map.ndf.exr"), "an older file");
  Program bake(command());
  const std::string temporary = wait_until_writing(bake);
  bake.send(SIGKILL);
  ASSERT_EQ(bake.wait().signal, SIGKILL) << "no temporary file appeared next to the final name";
  EXPECT_EQ(read_bytes(path("out/map.ndf.exr")), "an older file");
  EXPECT_EQ(temporary.rfind(".multum-tmp-" + std::to_string(bake.pid()) + "-", 0), 0u) << temporary;
  EXPECT_TRUE(temporary.ends_with("-map.ndf.exr")) << temporary;
  const std::string partial = ".multum-partial-map.ndf.exr";
  EXPECT_EQ(names(), (std::set<std::string>{"map.ndf.exr", temporary, partial}));

  make_map("small", 16);
  const ProgramResult other = multum({"bake", path("small_normal.png"), "-o", path("out/other.ndf.exr"), "--quiet"});
  EXPECT_EQ(other.exit_code, 0) << other.err;
  EXPECT_EQ(names(), (std::set<std::string>{"map.ndf.exr", "other.ndf.exr", temporary, partial}))
      << "another name's is left";
  const ProgramResult again = multum({"bake", path("small_normal.png"), "-o", path("out/map.ndf.exr"), "--quiet"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_EQ(names(), (std::set<std::string>{"map.ndf.exr", "other.ndf.exr"}));
  EXPECT_EQ(multum({"verify", path("out/map.ndf.exr")}).exit_code, 0);
}

TEST_F(InterruptTest, SigintAndSigtermLeaveNothing) {
  const double start = now();
  ASSERT_EQ(run_program(command()).exit_code, 0);
  const double whole = now() - start;
  std::filesystem::remove(path("out/map.ndf.exr"));
  for (const int signal : {SIGINT, SIGTERM})
    for (const double share : {0.0, 0.1, 0.25, 2.0}) {  // The value 2 selects the time of writing.
      SCOPED_TRACE("signal " + std::to_string(signal) + ", after " + std::to_string(share) + " of the bake");
      write_bytes(path("out/map.ndf.exr"), "an older file");
      Program bake(command());
      wait_until_fitting(bake);
      if (share > 1.0) EXPECT_NE(wait_until_writing(bake), "");
      else pause(share * whole);
      const double sent = now();
      bake.send(signal);
      const ProgramResult result = bake.wait();
      EXPECT_LT(now() - sent, 0.4 * whole) << "stopping took too long";
      expect_refusal(result, 130, {"cancelled"});
      EXPECT_EQ(result.out, "");
      EXPECT_EQ(names(), std::set<std::string>{"map.ndf.exr"});
      EXPECT_EQ(read_bytes(path("out/map.ndf.exr")), "an older file");
    }
}

}  // namespace
}  // namespace multum::testing
