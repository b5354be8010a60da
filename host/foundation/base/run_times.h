// SPDX-License-Identifier: Apache-2.0
// Measures the run times of alternatives in order to compare them. The alternatives run in turn, so that other load on
// the machine affects all of them. The result is the minimum of several rounds, because other load only adds time.
// Processor time covers all threads of this process.
//
// Elapsed time shows how long a user of this machine waits. The amount of work shows the cost of settings. Other
// programs hardly change the amount of work, so it can rank settings on a busy machine.
#pragma once

#include <functional>
#include <vector>

#include "host/foundation/base/progress.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {

/// The seconds that a run took. For several rounds, each value is the minimum of the rounds.
struct RunTime {
  double processor_seconds = 0.0;
  double elapsed_seconds = 0.0;
  double device_seconds = 0.0;  // the time that kernels took on a device other than the processors of this machine, by
                                // the device's timer

  double work_seconds() const { return processor_seconds + device_seconds; }
};
RunTime operator+(const RunTime& a, const RunTime& b);

/// Returns the processor seconds that this process has used so far, in all its threads.
double processor_seconds();

/// Returns the seconds that a device has worked, measured with its own timer. Returns nullopt if there is no such
/// device and only processors work.
using DeviceSeconds = std::function<double()>;

/// Measures the time since its construction.
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
/// compiling kernels, must be done before the call. One run is one unit of progress, and the work can be cancelled
/// between two runs.
std::vector<RunTime> time_in_turns(const std::vector<std::function<void()>>& runs, int rounds, Progress* progress,
                                   const DeviceSeconds& device_seconds = {});

}  // namespace multum
