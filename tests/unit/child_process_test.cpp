// SPDX-License-Identifier: Apache-2.0
// A child's end is told apart: exit code, signal, never started.
#include "host/base/child_process.h"

#include <gtest/gtest.h>

#include <csignal>

#include "tests/unit/test_folder.h"

namespace multum {
namespace {

TEST(ChildProcessTest, OutputOfBothStreamsAndExitCode) {
  const ChildResult result = run_child({"sh", "-c", "echo out; echo err >&2; exit 7"});
  EXPECT_EQ(result.exit_code, 7);
  EXPECT_EQ(result.signal, 0);
  EXPECT_EQ(result.output, "out\nerr\n");
}

TEST(ChildProcessTest, ArgumentsArriveAsTheyAre) {
  EXPECT_EQ(run_child({"printf", "%s|", "a b", "", "$HOME", "\"q'"}).output, "a b||$HOME|\"q'|");
}

TEST(ChildProcessTest, MoreOutputThanAPipeHolds) {
  EXPECT_EQ(run_child({"sh", "-c", "head -c 300000 /dev/zero | tr '\\0' x"}).output, std::string(300000, 'x'));
}

TEST(ChildProcessTest, ASignalIsNotAnExitCode) {
  const ChildResult result = run_child({"sh", "-c", "kill -SEGV $$"});
  EXPECT_EQ(result.exit_code, -1);
  EXPECT_EQ(result.signal, SIGSEGV);
}

TEST(ChildProcessTest, UsageIsTheChildsOwn) {
  // dd holds one block of 200 MiB, and fills it.
  const ChildResult busy = run_child({"dd", "if=/dev/zero", "of=/dev/null", "bs=200M", "count=1"});
  ASSERT_EQ(busy.exit_code, 0) << busy.output;
  EXPECT_GT(busy.usage.peak_memory_bytes, 200u << 20);
  EXPECT_LT(busy.usage.peak_memory_bytes, (300u << 20) + own_peak_memory_bytes());
  EXPECT_GT(busy.usage.cpu_seconds(), 0.0);
  const ChildResult idle = run_child({"sleep", "0.2"});
  EXPECT_GE(idle.usage.wall_seconds, 0.2);
  EXPECT_LT(idle.usage.cpu_seconds(), 0.2);
  EXPECT_LT(idle.usage.peak_memory_bytes, (100u << 20) + own_peak_memory_bytes())
      << "one child's peak counts for the next";
}

TEST(ChildProcessTest, AMissingProgramIsNamed) {
  testing::expect_error(ErrorCode::kEnvironment, {"multum-no-such-program", "cannot be started", "No such file"},
                        [] { run_child({"multum-no-such-program"}); });
}

}  // namespace
}  // namespace multum
