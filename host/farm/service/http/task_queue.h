// SPDX-License-Identifier: Apache-2.0
// Runs thousands of waiting tasks one at a time. Each task runs after all other work that is ready, so that tasks do
// not delay answers to monitors.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <deque>
#include <functional>
#include <new>

namespace multum {

/// Used on the thread of its io_context.
class TaskQueue {
 public:
  explicit TaskQueue(boost::asio::io_context& io) : io_(io) {}
  TaskQueue(const TaskQueue&) = delete;
  TaskQueue& operator=(const TaskQueue&) = delete;

  void add(std::function<void()> task) {
    tasks_.push_back(std::move(task));
    if (!is_posted_) post_next();
  }

 private:
  // Each task has its own handler, so that the io_context polls connections between two tasks. If there is no memory
  // for the next handler, the next call of add() posts it.
  void post_next() {
    boost::asio::post(io_, [this] {
      is_posted_ = false;
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      try {
        if (!tasks_.empty()) post_next();  // first, because a task may throw
      } catch (const std::bad_alloc&) {
      }
      task();
    });
    is_posted_ = true;
  }

  boost::asio::io_context& io_;
  std::deque<std::function<void()>> tasks_;
  bool is_posted_ = false;
};

}  // namespace multum
