// SPDX-License-Identifier: Apache-2.0
// Exceptions become exit codes and one line on stderr; a broken promise of ours stops the program.
#include "host/base/error.h"

#include <gtest/gtest.h>

#include <new>

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
  EXPECT_EQ(cancelled.message, "tool: cancelled, nothing unfinished was kept\n");
  const Outcome memory = guarded([](int, char**) -> int { throw std::bad_alloc(); });
  EXPECT_EQ(memory.code, 4);
  EXPECT_EQ(memory.message, "tool: out of memory\n");
  const Outcome surprise = guarded([](int, char**) -> int { throw std::logic_error("odd"); });
  EXPECT_EQ(surprise.code, 1);
  EXPECT_EQ(surprise.message, "tool: unexpected error: odd\n");
}

TEST(ErrorDeathTest, ChecksStopTheProgramInReleaseBuildsToo) {
  EXPECT_DEATH(MULTUM_CHECK(1 + 1 == 3), "error_test.cpp:[0-9]+: check failed: 1 \\+ 1 == 3");
}

}  // namespace
}  // namespace multum
