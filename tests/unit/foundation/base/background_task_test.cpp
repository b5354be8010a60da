// SPDX-License-Identifier: Apache-2.0
// Tests that tasks keep their order, run in parallel with their caller, and report a failure once.
#include "host/foundation/base/processes/background_task.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>
#include <vector>

namespace multum {
namespace {

TEST(BackgroundTaskTest, TasksRunOneAfterAnother) {
  for (const int threads : {1, 2}) {
    std::vector<int> done;  // only one thread at a time may write this, otherwise the sanitizers report an error
    BackgroundTask task;
    for (int i = 0; i < 100; ++i) task.run(threads, [&done, i] { done.push_back(i); });
    task.wait();
    ASSERT_EQ(done.size(), 100u);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  }
}

TEST(BackgroundTaskTest, RunsBesideItsCallerUnlessThereIsOneThread) {
  for (const int threads : {1, 2}) {
    std::thread::id where;
    BackgroundTask task;
    task.run(threads, [&where] { where = std::this_thread::get_id(); });
    task.wait();
    EXPECT_EQ(where == std::this_thread::get_id(), threads == 1);
  }
}

TEST(BackgroundTaskTest, WhatATaskThrowsIsThrownOnce) {
  BackgroundTask task;
  task.run(2, [] { throw std::runtime_error("full"); });
  EXPECT_THROW(task.run(2, [] { FAIL() << "the task started after a failure"; }), std::runtime_error);
  EXPECT_NO_THROW(task.wait());
}

}  // namespace
}  // namespace multum
