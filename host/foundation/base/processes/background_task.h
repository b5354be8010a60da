// SPDX-License-Identifier: Apache-2.0
// Runs one task at a time in another thread. Each task begins when the previous one has ended, so tasks run in order.
#pragma once

#include <functional>
#include <future>
#include <utility>

#include "host/foundation/base/messages/log_listener.h"

namespace multum {

class BackgroundTask {
 public:
  BackgroundTask() = default;
  /// Waits for the task, and ignores its exception.
  ~BackgroundTask() {
    if (running_.valid()) running_.wait();
  }
  BackgroundTask(const BackgroundTask&) = delete;
  BackgroundTask& operator=(const BackgroundTask&) = delete;

  /// Waits for the previous task, throws its exception if it had one, and begins the new task. If `threads` is 1, runs
  /// the task at once.
  void run(int threads, std::function<void()> task) {
    wait();
    if (threads == 1) task();
    else running_ = std::async(std::launch::async, with_own_log(std::move(task)));
  }
  /// Waits for the task, and throws its exception if it had one.
  void wait() {
    if (running_.valid()) running_.get();
  }

 private:
  std::future<void> running_;
};

}  // namespace multum
