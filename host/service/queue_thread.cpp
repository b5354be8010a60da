// SPDX-License-Identifier: Apache-2.0
#include "host/service/queue_thread.h"

#include <future>

namespace multum {
namespace {

// Tasks that share a commit. More would make the first of them wait long for the last.
constexpr std::size_t kBatchMax = 256;

}  // namespace

QueueThread::QueueThread(const std::string& path, RetryPolicy policy, Post post)
    : queue_(path, policy), post_(std::move(post)), thread_([this] { loop(); }) {}

QueueThread::~QueueThread() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void QueueThread::run(Work work, Done done) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back({std::move(work), std::move(done), nullptr});
  }
  wake_.notify_one();
}

void QueueThread::run_now(const Work& work) {
  std::promise<void> promise;
  // Not by `post`: the caller's thread is this one, which waits.
  std::exception_ptr error;
  run(
      [&](JobQueue& queue) {
        try {
          work(queue);
        } catch (...) {
          error = std::current_exception();
          throw;
        }
      },
      nullptr);
  run([&](JobQueue&) { promise.set_value(); }, nullptr);
  promise.get_future().wait();
  if (error) std::rethrow_exception(error);
}

std::size_t QueueThread::pending() const {
  const std::lock_guard lock(mutex_);
  return tasks_.size();
}

void QueueThread::loop() {
  for (;;) {
    std::vector<Task> batch;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return is_ending_ || !tasks_.empty(); });
      if (tasks_.empty()) return;
      if (tasks_.size() <= kBatchMax) {
        batch.swap(tasks_);
      } else {
        const auto end = tasks_.begin() + kBatchMax;
        batch.assign(std::make_move_iterator(tasks_.begin()), std::make_move_iterator(end));
        tasks_.erase(tasks_.begin(), end);
      }
    }
    if (!run_batch(batch) && batch.size() > 1) {
      // On a full disk one that writes takes all down with it: each by itself, those that only look come through.
      for (Task& task : batch) {
        task.error = nullptr;
        std::vector<Task> alone;
        alone.push_back(std::move(task));
        run_batch(alone);
        task = std::move(alone.front());
      }
    }
    // Each by itself: what else that thread has to do comes in between.
    for (Task& task : batch)
      if (task.done) post_([done = std::move(task.done), error = task.error] { done(error); });
  }
}

bool QueueThread::run_batch(std::vector<Task>& batch) {
  try {
    SqliteTransaction transaction(queue_.database());
    for (Task& task : batch) {
      try {
        SqliteSavepoint part(queue_.database());
        task.work(queue_);
        part.release();
      } catch (...) {
        task.error = std::current_exception();
        queue_.resync();
      }
    }
    transaction.commit();
    return true;
  } catch (...) {  // a full disk, as a rule: nothing of the batch is done
    for (Task& task : batch)
      if (!task.error) task.error = std::current_exception();
    try {
      queue_.resync();
    } catch (...) {  // the next batch says it again
    }
    return false;
  }
}

}  // namespace multum
