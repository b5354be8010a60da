// SPDX-License-Identifier: Apache-2.0
// Tests that times come from the fastest round. Every run must be executed once before any run is executed a second
// time.
#include "host/foundation/base/run_times.h"

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

// Uses this much processor time, however busy the machine is.
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
  EXPECT_LT(times[0].processor_seconds, 0.2) << "a slower round was counted";
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

// A device's time counts only during the run, as the smallest time of all rounds. It counts as work in addition to
// processor time.
TEST(RunTimesTest, TheDevicesClockCountsAsWork) {
  double device = 100.0;  // device time before the run
  int round = 0;
  const auto run = [&] { device += round++ == 1 ? 2.0 : 7.0; };
  const std::vector<RunTime> times = time_in_turns({run, [] {}}, 3, nullptr, [&] { return device; });
  EXPECT_DOUBLE_EQ(times[0].device_seconds, 2.0);
  EXPECT_DOUBLE_EQ(times[1].device_seconds, 0.0);
  EXPECT_DOUBLE_EQ(times[0].work_seconds(), times[0].processor_seconds + 2.0);
  const RunTime sum = RunTime{1.0, 2.0, 3.0} + RunTime{10.0, 20.0, 30.0};
  EXPECT_DOUBLE_EQ(sum.processor_seconds, 11.0);
  EXPECT_DOUBLE_EQ(sum.elapsed_seconds, 22.0);
  EXPECT_DOUBLE_EQ(sum.device_seconds, 33.0);
}

}  // namespace
}  // namespace multum
