// SPDX-License-Identifier: Apache-2.0
// Times runs that can be compared: in turns, so that what else the machine does falls on all of them, and the least of
// several, since other work only ever adds. Processor time is this process's, in all its threads.
#pragma once

#include <functional>
#include <vector>

#include "host/base/progress.h"

namespace multum {

/// Seconds of a run: the least processor time and the least elapsed time of all its rounds.
struct RunTime {
  double processor_seconds = 0.0;
  double elapsed_seconds = 0.0;
};

/// Of this process so far, in all its threads.
double processor_seconds();

constexpr int kTimedRounds = 3;

/// Runs all of `runs` once a round, `rounds` (at least 1) times. What is done at a first run alone, such as compiling
/// kernels, must have been done before. Progress: a unit a run; may cancel between two.
std::vector<RunTime> time_in_turns(const std::vector<std::function<void()>>& runs, int rounds, Progress* progress);

}  // namespace multum
