// SPDX-License-Identifier: Apache-2.0
#include "host/base/run_times.h"

#include <algorithm>
#include <ctime>
#include <limits>

#include "host/base/error.h"
#include "host/base/stopwatch.h"

namespace multum {

double processor_seconds() {
  timespec used{};
  MULTUM_CHECK(::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used) == 0);
  return static_cast<double>(used.tv_sec) + 1e-9 * static_cast<double>(used.tv_nsec);
}

std::vector<RunTime> time_in_turns(const std::vector<std::function<void()>>& runs, int rounds, Progress* progress) {
  MULTUM_CHECK(rounds >= 1);
  constexpr double kNone = std::numeric_limits<double>::infinity();
  std::vector<RunTime> least(runs.size(), {kNone, kNone});
  for (int round = 0; round < rounds; ++round)
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const Stopwatch stopwatch;
      const double before = processor_seconds();
      runs[i]();
      least[i].processor_seconds = std::min(least[i].processor_seconds, processor_seconds() - before);
      least[i].elapsed_seconds = std::min(least[i].elapsed_seconds, stopwatch.seconds());
      progress_advance(progress, 1);
    }
  return least;
}

}  // namespace multum
