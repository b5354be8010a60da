// SPDX-License-Identifier: Apache-2.0
// Tests that every kind of failure of a child process is recognised, and that no process or file descriptor remains.
#include "host/foundation/sandbox/helper_process.h"
#include "host/foundation/base/processes/sanitizers.h"

#include <sched.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <thread>
#include <utility>
#include <vector>

#include "host/foundation/sandbox/decoding_answer.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum::testing {
namespace {

constexpr HelperLimits kLimits = {std::uint64_t{256} << 20, std::chrono::milliseconds(20000)};
const std::string kFailingHelper = std::string(MULTUM_BIN_DIR) + "/failing_helper";

int open_files() {
  int count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

/// When it is destroyed, restores the limits of this process, which child processes inherit.
class KeptLimit {
 public:
  explicit KeptLimit(__rlimit_resource which) : which_(which) { ::getrlimit(which, &before_); }
  ~KeptLimit() { ::setrlimit(which_, &before_); }
  KeptLimit(const KeptLimit&) = delete;
  KeptLimit& operator=(const KeptLimit&) = delete;
  void set(rlim_t soft) const {
    const rlimit limit = {soft, before_.rlim_max};
    ASSERT_EQ(::setrlimit(which_, &limit), 0);
  }

 private:
  const __rlimit_resource which_;
  rlimit before_ = {};
};

bool lacked_memory(const std::string& request, const HelperLimits& limits = kLimits) {
  HelperProcess helper(kFailingHelper);
  try {
    helper.ask(request, limits, {});
  } catch (const HelperEnded& ended) {
    return ended.lacked_memory();
  }
  ADD_FAILURE() << request << " was answered";
  return false;
}

/// Returns the error code to which the answer of a decoder is converted.
ErrorCode code_of_answer(HelperProcess& helper, const std::string& request) {
  const std::string answer = helper.ask(request, kLimits, {});
  try {
    refuse_as_answered({"a.png", "OpenImageIO", kLimits.memory_max}, answer);
  } catch (const Error& error) {
    return error.code();
  }
}

/// Returns a description of how a child process ended after one request.
std::string end_of(const std::string& request, const HelperLimits& limits = kLimits) {
  HelperProcess helper(kFailingHelper);
  const pid_t pid = helper.pid();
  std::string end;
  try {
    end = "answered " + helper.ask(request, limits, {});
  } catch (const HelperEnded& ended) {
    end = ended.what();
    EXPECT_FALSE(helper.is_alive());
    EXPECT_EQ(::waitpid(pid, nullptr, WNOHANG), -1) << "a zombie";
    EXPECT_THROW(helper.ask("again", limits, {}), HelperEnded);
  }
  return end;
}

TEST(HelperProcessTest, EndsAreToldApart) {
  EXPECT_EQ(end_of("anything"), "answered nonsense");
  expect_says(end_of("exit"), {"exit code 7"});
  expect_says(end_of("announce"), {"announced", "18446744073709551615 bytes"});
  expect_says(end_of("chatter"), {"more bytes than"});
#ifndef MULTUM_SHADOW_MEMORY  // the sanitizer has its own messages for signals
  expect_says(end_of("abort"), {"signal 6", "Aborted", "a library's last words"});
  expect_says(end_of("segfault"), {"signal 11", "Segmentation fault"});
#endif
}

TEST(HelperProcessTest, TheSystemsKillAndAProgramThatIsNotLoadedAreWantOfMemory) {
  EXPECT_TRUE(lacked_memory("kill"));
  EXPECT_TRUE(lacked_memory("unloaded"));
  HelperLimits limits = kLimits;
  limits.time_max = std::chrono::milliseconds(100);
  EXPECT_FALSE(lacked_memory("exit"));
  EXPECT_FALSE(lacked_memory("hang", limits)) << "killed by the requesting process";
  EXPECT_FALSE(lacked_memory("chatter"));
#ifndef MULTUM_SHADOW_MEMORY
  EXPECT_FALSE(lacked_memory("segfault"));
  const KeptLimit space(RLIMIT_AS);
  limits.memory_max = std::uint64_t{1} << 40;
  space.set(limits.memory_max);
  EXPECT_TRUE(lacked_memory("segfault", limits)) << "some libraries ignore that malloc() failed";
#endif
}

#ifndef MULTUM_SHADOW_MEMORY
TEST(HelperProcessTest, WantOfMemoryIsTheFilesOnlyWhereAllThatIsAllowedIsThere) {
  for (const char* request : {"hungry", "words"}) {
    SCOPED_TRACE(request);
    HelperProcess helper(kFailingHelper);
    EXPECT_EQ(code_of_answer(helper, request), ErrorCode::kInput);
    const rlimit space = {std::uint64_t{128} << 20, RLIM_INFINITY};
    ASSERT_EQ(::prlimit(helper.pid(), RLIMIT_AS, &space, nullptr), 0);
    EXPECT_EQ(code_of_answer(helper, request), ErrorCode::kEnvironment) << "ulimit -v";
    HelperProcess other(kFailingHelper);
    const rlimit data = {kLimits.memory_max / 2, kLimits.memory_max / 2};
    ASSERT_EQ(::prlimit(other.pid(), RLIMIT_DATA, &data, nullptr), 0);
    EXPECT_EQ(code_of_answer(other, request), ErrorCode::kEnvironment) << "ulimit -d";
  }
}
#endif

// This process was stopped, or had no processor, for longer than the child's time limit.
TEST(HelperProcessTest, AGapBetweenTwoLooksIsNotTheChilds) {
  HelperProcess helper(kFailingHelper);
  HelperLimits limits = kLimits;
  limits.time_max = std::chrono::milliseconds(500);
  bool has_slept = false;
  const auto sleep_once = [&] {
    if (!std::exchange(has_slept, true)) std::this_thread::sleep_for(std::chrono::milliseconds(700));
  };
  EXPECT_EQ(helper.ask("nap", limits, sleep_once), "done");
  EXPECT_TRUE(has_slept);
}

TEST(HelperProcessTest, TimeIsLimited) {
  HelperLimits limits = kLimits;
  limits.time_max = std::chrono::milliseconds(150);
  const auto start = std::chrono::steady_clock::now();
  expect_says(end_of("hang", limits), {"more than 150 ms"});
  expect_says(end_of("spin", limits), {"more than 150 ms"});
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
}

// Children run in the lowest scheduling class, and one of them has a second thread. They compete with twice as many
// threads as there are processors.
TEST(HelperProcessTest, TimeThatOthersHaveTheProcessorsDoesNotCount) {
  HelperProcess helper(kFailingHelper), threaded(kFailingHelper);
  const sched_param lowest = {};
  for (const HelperProcess* one : {&helper, &threaded})
    ASSERT_EQ(::sched_setscheduler(one->pid(), SCHED_IDLE, &lowest), 0);
  HelperLimits limits = kLimits;
  limits.time_max = std::chrono::milliseconds(600);
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::jthread> others;
  for (unsigned i = 0; i < 2 * std::max(1u, std::thread::hardware_concurrency()); ++i)
    others.emplace_back([&] {
      while (std::chrono::steady_clock::now() - start < std::chrono::seconds(2)) {
      }
    });
  std::string answer = "none";
  std::jthread waiting([&] {
    try {
      answer = threaded.ask("thread", limits, {});
    } catch (const HelperEnded& ended) {
      answer = ended.what();
    }
  });
  EXPECT_EQ(helper.ask("work", limits, {}), "done");
  waiting.join();
  EXPECT_EQ(answer, "done");
  EXPECT_GT(std::chrono::steady_clock::now() - start, limits.time_max) << "no other process slowed the child";
}

TEST(HelperProcessTest, MemoryIsLimited) {
  const std::string end = end_of("eat");
#ifdef MULTUM_SHADOW_MEMORY
  expect_says(end, {"bytes of memory"});
#else
  EXPECT_EQ(end, "answered full");  // its allocations failed
#endif
}

TEST(HelperProcessTest, AChildHasItsOwnFilesAndLimits) {
  EXPECT_EQ(end_of("files"), "answered 0 1 2 3 4 ");
  const std::string limits = end_of("limits");
  EXPECT_TRUE(limits.starts_with("answered 0 ")) << limits;  // no core files
  EXPECT_LT(std::stol(limits.substr(11)), 20000) << limits;  // seconds of processor time
}

TEST(HelperProcessTest, MemoryIsShared) {
  HelperProcess helper(kFailingHelper);
  std::byte* const memory = helper.memory().reserve(4096);
  helper.ask("write", kLimits, {});
  EXPECT_EQ(memory[0], std::byte{42});
  helper.memory().reserve(std::size_t{1} << 20)[0] = std::byte{0};
  helper.ask("write", kLimits, {});
  EXPECT_EQ(helper.memory().reserve(1)[0], std::byte{42});
}

TEST(HelperProcessTest, WhoWaitsMayStopWaiting) {
  HelperProcess helper(kFailingHelper);
  int called = 0;
  const auto stop = [&] {
    if (++called == 2) throw Cancelled();
  };
  EXPECT_THROW(helper.ask("hang", kLimits, stop), Cancelled);
  EXPECT_FALSE(helper.is_alive()) << "its answer would be taken as the next request's answer";
}

TEST(HelperProcessTest, NothingStays) {
  end_of("anything");
  const int before = open_files();
  for (const char* request : {"anything", "exit", "announce"}) end_of(request);
  expect_error(ErrorCode::kEnvironment, {"/none: cannot be started: No such file"},
               [] { HelperProcess none("/none"); });
  EXPECT_EQ(open_files(), before);
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

// The child ends even if it hangs, and even if its parent is killed without cleaning up.
TEST(HelperProcessTest, AChildEndsWithWhoAsked) {
  int pipe_ends[2];
  ASSERT_EQ(::pipe(pipe_ends), 0);
  const pid_t asker = ::fork();
  if (asker == 0) {
    HelperProcess helper(kFailingHelper);
    const pid_t pid = helper.pid();
    if (::write(pipe_ends[1], &pid, sizeof(pid)) != sizeof(pid)) ::_exit(1);
    helper.ask("hang", kLimits, {});
    ::_exit(0);
  }
  pid_t helper = 0;
  ASSERT_EQ(::read(pipe_ends[0], &helper, sizeof(helper)), static_cast<ssize_t>(sizeof(helper)));
  ::close(pipe_ends[0]);
  ::close(pipe_ends[1]);
  ::kill(asker, SIGKILL);
  ::waitpid(asker, nullptr, 0);
  const std::string status = "/proc/" + std::to_string(helper) + "/stat";
  // The process has ended, or it is a zombie of the process that adopted it.
  const auto is_there = [&] {
    std::ifstream in(status);
    std::string pid, name, state;
    return static_cast<bool>(in >> pid >> name >> state) && state != "Z" && state != "X";
  };
  for (int tries = 0; tries < 500 && is_there(); ++tries) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_FALSE(is_there());
}

}  // namespace
}  // namespace multum::testing
