// SPDX-License-Identifier: Apache-2.0
// Tests that exceptions become exit codes and one line on stderr, and that a failed check stops the program.
#include "host/foundation/base/error.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <new>
#include <system_error>

#include "host/foundation/base/system_failure.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

struct Outcome {
  int code;
  std::string message;
};

Outcome guarded(int (*body)(int, char**)) {
  ::testing::internal::CaptureStderr();
  const int code = run_guarded("tool", body, 0, nullptr);
  return {code, ::testing::internal::GetCapturedStderr()};
}

TEST(ErrorTest, EachKindHasItsExitCode) {
  EXPECT_EQ(exit_code(ErrorCode::kUsage), 2);
  EXPECT_EQ(exit_code(ErrorCode::kInput), 3);
  EXPECT_EQ(exit_code(ErrorCode::kEnvironment), 4);
  EXPECT_EQ(exit_code(ErrorCode::kVerification), 5);
}

TEST(ErrorTest, RunGuardedMapsExceptionsToCodesAndMessages) {
  const Outcome fine = guarded([](int, char**) { return 0; });
  EXPECT_EQ(fine.code, 0);
  EXPECT_EQ(fine.message, "");
  EXPECT_EQ(guarded([](int, char**) { return 7; }).code, 7);
  const Outcome input = guarded([](int, char**) -> int { throw Error(ErrorCode::kInput, "a.png: found nothing"); });
  EXPECT_EQ(input.code, 3);
  EXPECT_EQ(input.message, "tool: a.png: found nothing\n");
  const Outcome cancelled = guarded([](int, char**) -> int { throw Cancelled(); });
  EXPECT_EQ(cancelled.code, 130);
  EXPECT_EQ(cancelled.message, "tool: cancelled; no unfinished files remain\n");
  const Outcome memory = guarded([](int, char**) -> int { throw std::bad_alloc(); });
  EXPECT_EQ(memory.code, 4);
  EXPECT_EQ(memory.message, "tool: out of memory\n");
  const Outcome surprise = guarded([](int, char**) -> int { throw std::logic_error("odd"); });
  EXPECT_EQ(surprise.code, 1);
  EXPECT_EQ(surprise.message, "tool: unexpected error: odd\n");
}

// A write beyond the limit on file sizes fails like a write to a full disk, and the message names the limit.
TEST(ErrorTest, ALimitOfFileSizesIsAnErrorAndNoSignal) {
  const testing::TemporaryFolder folder;
  static std::string path;
  path = folder / "a";
  rlimit before = {};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit little = {4096, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &little);
  std::signal(SIGXFSZ, SIG_DFL);
  const Outcome outcome = guarded([](int, char**) -> int {
    const int file = ::open(path.c_str(), O_WRONLY | O_CREAT, 0600);
    const std::string page(4096, 'x');
    if (::write(file, page.data(), page.size()) != 4096) return 10;
    if (::write(file, page.data(), page.size()) > 0) return 11;
    const int number = errno;
    ::close(file);
    errno = number;
    fail_by_errno(path, "cannot be written");
  });
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(outcome.code, 4);
  EXPECT_EQ(outcome.message,
            "tool: " + path + ": cannot be written: File too large; files may have 4096 bytes (ulimit -f)\n");
}

// Tests after which errors a loop over files continues, and after which errors it stops.
TEST(ErrorTest, WhatTheSystemRefusesIsAnErrorOfItsFile) {
  const auto caught = [](auto thrown) {
    try {
      throw thrown;
    } catch (...) {
      return caught_error("a.png");
    }
  };
  const Error memory = caught(std::bad_alloc());
  EXPECT_EQ(memory.code(), ErrorCode::kEnvironment);
  EXPECT_EQ(std::string(memory.what()).find("a.png: out of memory"), 0u);
  const Error thread = caught(std::system_error(EAGAIN, std::generic_category(), "thread"));
  EXPECT_EQ(thread.code(), ErrorCode::kEnvironment);
  EXPECT_EQ(std::string(thread.what()).find("a.png: thread: Resource temporarily unavailable"), 0u);
  const Error file = caught(std::filesystem::filesystem_error("x", std::make_error_code(std::errc::io_error)));
  EXPECT_EQ(file.code(), ErrorCode::kEnvironment);
  const Error name = caught(std::filesystem::filesystem_error("x", std::make_error_code(std::errc::filename_too_long)));
  EXPECT_EQ(name.code(), ErrorCode::kUsage);
  const Error input = caught(Error(ErrorCode::kInput, "b.png: damaged"));
  EXPECT_EQ(input.code(), ErrorCode::kInput);
  EXPECT_STREQ(input.what(), "b.png: damaged");
  EXPECT_THROW(caught(Cancelled()), Cancelled);
  EXPECT_THROW(caught(std::logic_error("a fault of ours")), std::logic_error);
}

TEST(ErrorTest, LimitsOfTheProcessAreNamed) {
  EXPECT_EQ(errno_text(EMFILE).find("Too many open files; this process may have "), 0u);
  EXPECT_NE(errno_text(EMFILE).find("(ulimit -n)"), std::string::npos);
  EXPECT_EQ(errno_text(ENOENT), "No such file or directory");
  errno = ENAMETOOLONG;
  testing::expect_error(ErrorCode::kUsage, {"a: cannot be created: File name too long"},
                        [] { fail_by_errno("a", "cannot be created"); });
  EXPECT_EQ(
      guarded([](int, char**) -> int { throw std::system_error(EAGAIN, std::generic_category(), "thread"); }).code, 4);
}

TEST(ErrorDeathTest, ChecksStopTheProgramInReleaseBuildsToo) {
  EXPECT_DEATH(MULTUM_CHECK(1 + 1 == 3), "error_test.cpp:[0-9]+: check failed: 1 \\+ 1 == 3");
}

}  // namespace
}  // namespace multum
