// SPDX-License-Identifier: Apache-2.0
// Times runs that can be compared: in turns, so that what else the machine does falls on all of them, and the least of
// several, since other work only ever adds. Processor time is this process's, in all its threads.
//
// Elapsed time says how long someone waits on this machine now. Work says what settings cost: other programs hardly
// change it, so that it can rank settings on a busy machine.
#pragma once

#include <functional>
#include <vector>

#include "host/foundation/base/progress.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {

/// Seconds of a run; of several rounds the least of each.
struct RunTime {
  double processor_seconds = 0.0;
  double elapsed_seconds = 0.0;
  double device_seconds = 0.0;  // of kernels on a device that is no processor of this machine, by its own clock

  double work_seconds() const { return processor_seconds + device_seconds; }
};
RunTime operator+(const RunTime& a, const RunTime& b);

/// Of this process so far, in all its threads.
double processor_seconds();

/// What a device has worked so far, by its own clock; empty: no other device works than processors.
using DeviceSeconds = std::function<double()>;

/// Times what happens since it was made.
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

/// Runs all of `runs` once a round, `rounds` (at least 1) times. What is done at a first run alone, such as compiling
/// kernels, must have been done before. Progress: a unit a run; may cancel between two.
std::vector<RunTime> time_in_turns(const std::vector<std::function<void()>>& runs, int rounds, Progress* progress,
                                   const DeviceSeconds& device_seconds = {});

}  // namespace multum
