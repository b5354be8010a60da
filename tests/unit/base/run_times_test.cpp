// SPDX-License-Identifier: Apache-2.0
// Times are those of the quickest round, and every run has had its turn before any has its next.
#include "host/base/run_times.h"

#include <gtest/gtest.h>

#include <chrono>
#include <ctime>
#include <string>
#include <thread>

namespace multum {
namespace {

double processor_now() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

// Takes that much processor time, however busy the machine is.
void work(double seconds) {
  const double end = processor_now() + seconds;
  while (processor_now() < end) {
  }
}

TEST(RunTimesTest, RunsInTurns) {
  std::string order;
  time_in_turns({[&] { order += 'a'; }, [&] { order += 'b'; }, [&] { order += 'c'; }}, 3, nullptr);
  EXPECT_EQ(order, "abcabcabc");
}

TEST(RunTimesTest, TakesTheLeastOfAllRounds) {
  int round = 0;
  const std::vector<RunTime> times = time_in_turns({[&] { work(round++ == 1 ? 0.005 : 0.2); }}, 3, nullptr);
  ASSERT_EQ(times.size(), 1u);
  EXPECT_GE(times[0].processor_seconds, 0.005);
  EXPECT_LT(times[0].processor_seconds, 0.2) << "a round that took longer counts";
}

TEST(RunTimesTest, ProcessorTimeIsOfAllThreadsAndNotOfSleep) {
  const auto sleep = [] { std::this_thread::sleep_for(std::chrono::milliseconds(50)); };
  const auto two_threads = [] {
    std::jthread other([] { work(0.02); });
    other.join();
    work(0.02);
  };
  const std::vector<RunTime> times = time_in_turns({sleep, two_threads}, 1, nullptr);
  EXPECT_GE(times[0].elapsed_seconds, 0.05);
  EXPECT_LT(times[0].processor_seconds, times[0].elapsed_seconds);
  EXPECT_GE(times[1].processor_seconds, 0.04);
}

}  // namespace
}  // namespace multum
