// SPDX-License-Identifier: Apache-2.0
// Tests that progress counts the reported units, and stops at the next report after a request to stop.
#include "host/foundation/base/progress.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <thread>
#include <vector>

#include "host/foundation/base/error.h"

namespace multum {
namespace {

TEST(ProgressTest, ReportsStagesAndUnits) {
  std::vector<ProgressEvent> events;
  Progress progress([&](const ProgressEvent& event) {
    events.push_back(event);
    return true;
  });
  progress.stage("read");
  progress.start(10);
  progress.stage("fit");
  progress.advance(4);
  progress.advance(6);
  ASSERT_EQ(events.size(), 5u);
  EXPECT_EQ(events[0].stage, "read");
  EXPECT_EQ(events[0].units_total, 0u) << "unknown before start()";
  EXPECT_EQ(events[1].units_total, 10u);
  EXPECT_EQ(events[3].stage, "fit");
  EXPECT_EQ(events[3].units_done, 4u);
  EXPECT_EQ(events[4].units_done, 10u);
}

TEST(ProgressTest, CancelsAtTheNextReportAndStaysUsable) {
  bool go_on = true;
  Progress progress([&](const ProgressEvent&) { return go_on; });
  progress.start(3);
  progress.advance(1);
  go_on = false;
  EXPECT_THROW(progress.advance(1), Cancelled);
  EXPECT_THROW(progress.stage("x"), Cancelled);
  go_on = true;
  EXPECT_NO_THROW(progress.advance(1));
}

TEST(ProgressTest, NobodyNeedsToListen) {
  progress_start(nullptr, 1);
  progress_stage(nullptr, "x");
  progress_advance(nullptr, 1);
  Progress silent(nullptr);
  EXPECT_NO_THROW(silent.advance(1));
}

TEST(ProgressTest, ABarThatIsNoTerminalPrintsNothing) {
  ::testing::internal::CaptureStderr();
  {
    const auto progress = make_terminal_progress(true);
    progress->start(1);
    progress->advance(1);
  }
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

// Runs in a separate process, because a request to stop cannot be withdrawn.
TEST(ProgressDeathTest, SignalsCancelOnceAndThenEndTheProgram) {
  for (const int signal : {SIGINT, SIGTERM}) {
    EXPECT_EXIT(
        {
          const auto progress = make_terminal_progress(false);
          progress->start(2);
          std::raise(signal);
          try {
            progress->advance(1);
          } catch (const Cancelled&) {
            std::_Exit(42);
          }
          std::_Exit(1);
        },
        ::testing::ExitedWithCode(42), "");
    EXPECT_EXIT(
        {
          const auto progress = make_terminal_progress(false);
          std::raise(signal);
          std::raise(signal);
          std::_Exit(42);
        },
        ::testing::ExitedWithCode(42), "")
        << "two signals from one sender";
    EXPECT_EXIT(
        {
          const auto progress = make_terminal_progress(false);
          progress->start(2);
          std::signal(signal, SIG_DFL);  // LLVM does the same
          progress->advance(1);
          std::raise(signal);
          try {
            progress->advance(1);
          } catch (const Cancelled&) {
            std::_Exit(42);
          }
          std::_Exit(1);
        },
        ::testing::ExitedWithCode(42), "")
        << "other handlers are removed";
    EXPECT_EXIT(
        {
          const auto progress = make_terminal_progress(false);
          std::raise(signal);
          std::this_thread::sleep_for(std::chrono::milliseconds(2100));
          std::raise(SIGTERM);
          std::_Exit(42);
        },
        ::testing::ExitedWithCode(42), "")
        << "the same result on an overloaded machine";
    EXPECT_EXIT(
        {
          const auto progress = make_terminal_progress(false);
          std::raise(signal);
          std::this_thread::sleep_for(std::chrono::milliseconds(2100));
          std::raise(SIGINT);
          std::_Exit(1);
        },
        ::testing::KilledBySignal(SIGINT), "");
  }
}

}  // namespace
}  // namespace multum
