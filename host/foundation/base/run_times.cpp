// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/run_times.h"

#include <algorithm>
#include <ctime>
#include <limits>
#include <utility>

#include "host/foundation/base/error.h"

namespace multum {

double processor_seconds() {
  timespec used{};
  MULTUM_CHECK(::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used) == 0);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

RunTime operator+(const RunTime& a, const RunTime& b) {
  return {a.processor_seconds + b.processor_seconds, a.elapsed_seconds + b.elapsed_seconds,
          a.device_seconds + b.device_seconds};
}

RunClock::RunClock(DeviceSeconds device_seconds)
    : device_seconds_(std::move(device_seconds)),
      device_before_(device_seconds_ ? device_seconds_() : 0.0),
      processor_before_(processor_seconds()) {}

RunTime RunClock::time() const {
  // Reads the time of the device first, because this call waits until the device has finished its work.
  const double device = device_seconds_ ? device_seconds_() - device_before_ : 0.0;
  return {processor_seconds() - processor_before_, stopwatch_.seconds(), device};
}

std::vector<RunTime> time_in_turns(const std::vector<std::function<void()>>& runs, int rounds, Progress* progress,
                                   const DeviceSeconds& device_seconds) {
  MULTUM_CHECK(rounds >= 1);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<RunTime> least(runs.size(), {kNone, kNone, kNone});
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const RunClock clock(device_seconds);
      runs[i]();
      const RunTime time = clock.time();
      for (double RunTime::*part : {&RunTime::processor_seconds, &RunTime::elapsed_seconds, &RunTime::device_seconds})
        least[i].*part = std::min(least[i].*part, time.*part);
      progress_advance(progress, 1);
    }
  return least;
}

}  // namespace multum
