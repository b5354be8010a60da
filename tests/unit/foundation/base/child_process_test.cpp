// SPDX-License-Identifier: Apache-2.0
// Tests that the end of a child process is reported correctly: its exit code, a signal, or that it never started.
#include "host/foundation/base/processes/child_process.h"
#include "host/foundation/base/processes/sanitizers.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <fstream>
#include <thread>

#include "tests/unit/foundation/base/test_folder.h"

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

// This program ignores the signal and checks the results of its writes, but other programs may not do so.
TEST(ChildProcessTest, AChildHasTheSignalOfFileSizesAsAtAProgramsStart) {
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  const std::string line = run_child({"grep", "SigIgn", "/proc/self/status"}).output;
  std::signal(SIGXFSZ, before);
  const std::uint64_t ignored = std::stoull(line.substr(line.find(':') + 1), nullptr, 16);
  EXPECT_EQ(ignored >> (SIGXFSZ - 1) & 1, 0u) << line;
}

TEST(ChildProcessTest, UsageIsTheChildsOwn) {
  // dd allocates one block of 200 MiB and fills it.
  const ChildResult busy = run_child({"dd", "if=/dev/zero", "of=/dev/null", "bs=200M", "count=1"});
  ASSERT_EQ(busy.exit_code, 0) << busy.output;
  EXPECT_GT(busy.usage.peak_memory_bytes, 200u << 20);
  EXPECT_LT(busy.usage.peak_memory_bytes, (300u << 20) + own_peak_memory_bytes());
  EXPECT_GT(busy.usage.cpu_seconds(), 0.0);
  const ChildResult idle = run_child({"sleep", "0.2"});
  EXPECT_GE(idle.usage.wall_seconds, 0.2);
  EXPECT_LT(idle.usage.cpu_seconds(), 0.2);
  EXPECT_LT(idle.usage.peak_memory_bytes, (100u << 20) + own_peak_memory_bytes())
      << "one child's peak memory counts for the next child";
}

TEST(ChildProcessTest, LimitsEndWhatTheChildHasStartedToo) {
  // The grandchild would keep the pipe open for a minute.
  const ChildResult slow = run_child({"sh", "-c", "sleep 60 & sleep 60"}, {std::chrono::milliseconds(300)});
  EXPECT_TRUE(slow.is_over_time);
  EXPECT_EQ(slow.signal, SIGKILL);
  EXPECT_LT(slow.usage.wall_seconds, 20.0);
  ChildLimits limits{std::chrono::minutes(1)};
  limits.is_cancelled = [] { return true; };
  EXPECT_EQ(run_child({"sleep", "60"}, limits).signal, SIGKILL);
}

TEST(ChildProcessTest, LimitedChildrenAreNicerAndHaveLessMemory) {
  ChildLimits limits{std::chrono::minutes(1), 7, std::uint64_t{64} << 20};
  const ChildResult nice = run_child({"sh", "-c", "sleep 0.2; nice"}, limits);
  EXPECT_EQ(nice.output, "7\n");
  EXPECT_FALSE(nice.is_over_time);
#ifndef MULTUM_SHADOW_MEMORY
  EXPECT_NE(run_child({"sh", "-c", "sleep 0.2; exec dd if=/dev/zero of=/dev/null bs=200M count=1"}, limits).exit_code,
            0);
#endif
}

// If the parent of a child is killed (-9), the child also ends, even after an exec.
TEST(ChildProcessTest, AChildEndsWithWhoStartedIt) {
  for (const bool is_limited : {false, true}) {
    int pipe_ends[2];
    ASSERT_EQ(::pipe(pipe_ends), 0);
    const pid_t starter = ::fork();
    if (starter == 0) {
      ::dup2(pipe_ends[1], STDERR_FILENO);  // the child prints its id to a stream that the parent does not collect
      const std::vector<std::string> command = {
          "sh", "-c", "echo $$ > /proc/" + std::to_string(::getpid()) + "/fd/2; exec sleep 60"};
      if (is_limited) run_child(command, ChildLimits{std::chrono::minutes(2)});
      else run_child(command);
      ::_exit(0);
    }
    std::string said(20, '\0');
    const ssize_t count = ::read(pipe_ends[0], said.data(), said.size());
    ASSERT_GT(count, 0);
    const int child = std::stoi(said);
    ::kill(starter, SIGKILL);
    ::waitpid(starter, nullptr, 0);
    ::close(pipe_ends[0]);
    ::close(pipe_ends[1]);
    // The process has ended, or it is a zombie of the process that adopted it.
    const auto is_there = [&] {
      std::ifstream in("/proc/" + std::to_string(child) + "/stat");
      std::string pid, name, state;
      return static_cast<bool>(in >> pid >> name >> state) && state != "Z" && state != "X";
    };
    for (int tries = 0; tries < 250 && is_there(); ++tries) std::this_thread::sleep_for(std::chrono::milliseconds(20));
    EXPECT_FALSE(is_there()) << is_limited;
    ::kill(child, SIGKILL);
  }
}

TEST(ChildProcessTest, AChildHasNoFilesOfItsParent) {
  std::vector<int> opened;
  for (int i = 0; i < 20; ++i) opened.push_back(::open("/dev/null", O_RDONLY));
  EXPECT_EQ(run_child({"sh", "-c", "ls /proc/self/fd | wc -l"}).output, "4\n");  // three, plus the folder that ls reads
  for (const int one : opened) ::close(one);
}

TEST(ChildProcessTest, AMissingProgramIsNamed) {
  testing::expect_error(ErrorCode::kEnvironment, {"multum-no-such-program", "cannot be started", "No such file"},
                        [] { run_child({"multum-no-such-program"}); });
}

}  // namespace
}  // namespace multum
