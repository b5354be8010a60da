// SPDX-License-Identifier: Apache-2.0
// Times runs for comparison. Runs alternate, so that other load on the machine affects all of them. The result is the
// minimum of several rounds, because other load only adds time. Processor time covers all threads of this process.
//
// Elapsed time shows how long a user of this machine waits. Work shows the cost of settings. Other programs hardly
// change the amount of work, so it can rank settings on a busy machine.
#pragma once

#include <functional>
#include <vector>

#include "host/foundation/base/progress.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {

/// Seconds of a run; for several rounds, the minimum of each value.
struct RunTime {
  double processor_seconds = 0.0;
  double elapsed_seconds = 0.0;
  double device_seconds = 0.0;  // time of kernels on other devices than this machine's processors, by the device's
                                // timer

  double work_seconds() const { return processor_seconds + device_seconds; }
};
RunTime operator+(const RunTime& a, const RunTime& b);

/// Processor seconds of this process so far, in all its threads.
double processor_seconds();

/// Returns the seconds that a device has worked, measured with its own timer. Empty if there is no such device and only
/// processors work.
using DeviceSeconds = std::function<double()>;

/// Times the work since its construction.
class RunClock {
 public:
  explicit RunClock(DeviceSeconds device_seconds = {});
  RunTime time() const;

 private:
  const DeviceSeconds device_seconds_;
  const double device_before_;
  const double processor_before_;
  const Stopwatch stopwatch_;
};

constexpr int kTimedRounds = 3;

/// Runs all of `runs` once per round, for `rounds` (at least 1) rounds. Work that only the first run would do, such as
/// compiling kernels, must be done before the call. Progress counts one unit per run, and may cancel between two runs.
std::vector<RunTime> time_in_turns(const std::vector<std::function<void()>>& runs, int rounds, Progress* progress,
                                   const DeviceSeconds& device_seconds = {});

}  // namespace multum
