// SPDX-License-Identifier: Apache-2.0
// Runs one task at a time in another thread: the next begins when the one before is done, so that their order stays.
#pragma once

#include <functional>
#include <future>
#include <utility>

namespace multum {

class BackgroundTask {
 public:
  BackgroundTask() = default;
  /// Waits; what went wrong is lost, as it is when an exception unwinds.
  ~BackgroundTask() {
    if (running_.valid()) running_.wait();
  }
  BackgroundTask(const BackgroundTask&) = delete;
  BackgroundTask& operator=(const BackgroundTask&) = delete;

  /// Waits for the task before, throws what it threw, and begins this one. `threads` 1: it runs at once.
  void run(int threads, std::function<void()> task) {
    wait();
    if (threads == 1) task();
    else running_ = std::async(std::launch::async, std::move(task));
  }
  /// Throws what the task threw.
  void wait() {
    if (running_.valid()) running_.get();
  }

 private:
  std::future<void> running_;
};

}  // namespace multum
