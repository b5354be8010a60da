// SPDX-License-Identifier: Apache-2.0
// Measures wall time and processor time in seconds.
#pragma once

#include <chrono>
#include <ctime>

namespace multum {

/// Measures the time since its construction or its last lap.
class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(Clock::now() - start_).count(); }
  /// Returns the seconds so far and starts again at 0.
  double lap() {
    const Clock::time_point now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - start_).count();
    start_ = now;
    return seconds;
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point start_ = Clock::now();
};

/// Measures the processor time of the calling thread since construction. Other programs do not affect this time.
class ThreadStopwatch {
 public:
  double seconds() const { return now() - start_; }

 private:
  static double now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double start_ = now();
};

/// Adds the seconds of the object's lifetime to `total`.
class ScopedStopwatch {
 public:
  explicit ScopedStopwatch(double& total) : total_(total) {}
  ~ScopedStopwatch() { total_ += stopwatch_.seconds(); }
  ScopedStopwatch(const ScopedStopwatch&) = delete;
  ScopedStopwatch& operator=(const ScopedStopwatch&) = delete;

 private:
  double& total_;
  Stopwatch stopwatch_;
};

}  // namespace multum
