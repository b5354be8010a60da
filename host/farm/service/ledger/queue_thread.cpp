// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/queue_thread.h"

#include <chrono>
#include <future>
#include <new>
#include <thread>

#include "host/farm/service/files/no_space.h"
#include "host/farm/service/log/service_log.h"

namespace multum {
namespace {

// The largest number of tasks per commit. With more tasks, the first task would wait too long for the last one.
constexpr std::size_t kBatchMax = 256;

// Repeats `work` until there is enough memory, so that callers get the result in any case.
template <typename Work>
void until_it_can(const Work& work) {
  for (;;) {
    try {
      return work();
    } catch (const std::bad_alloc&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

bool says_no_space(const std::exception_ptr& error) {
  try {
    if (error) std::rethrow_exception(error);
  } catch (const NoSpaceError&) {
    return true;
  } catch (...) {
  }
  return false;
}

}  // namespace

QueueThread::QueueThread(const LedgerSettings& settings, Post post)
    : queue_(settings), post_(std::move(post)), thread_([this] { loop(); }) {}

QueueThread::~QueueThread() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void QueueThread::add(Task task) {
  {
    const std::lock_guard lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  wake_.notify_one();
}

void QueueThread::run(Work work, Done done) { add({std::move(work), std::move(done), nullptr, false}); }

void QueueThread::run_now(const Work& work) {
  std::promise<std::exception_ptr> ended;
  // The result is not sent through `post`, because the caller's thread waits. Waits for the commit, because the commit
  // may fail.
  add({work, [&](const std::exception_ptr& error) { ended.set_value(error); }, nullptr, true});
  if (const std::exception_ptr error = ended.get_future().get()) std::rethrow_exception(error);
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
        until_it_can([&] { batch.reserve(kBatchMax); });
        const auto end = tasks_.begin() + kBatchMax;
        batch.assign(std::make_move_iterator(tasks_.begin()), std::make_move_iterator(end));
        tasks_.erase(tasks_.begin(), end);
      }
    }
    if (!run_batch(batch) && batch.size() > 1) {
      // On a full disk, one writing task makes all tasks of a batch fail. If tasks run one by one, those that only read
      // succeed.
      for (Task& task : batch) {
        task.error = nullptr;
        std::vector<Task> alone;
        until_it_can([&] { alone.reserve(1); });
        alone.push_back(std::move(task));
        run_batch(alone);
        task = std::move(alone.front());
      }
    }
    // Posts each result separately, so that the other thread can do other work in between.
    for (Task& task : batch) {
      if (!task.done) continue;
      if (task.is_waited_for) task.done(task.error);
      else until_it_can([&] { post_([done = task.done, error = task.error] { done(error); }); });
    }
  }
}

// Called at the start of a batch and before its commit. Clients must not be told that their data is safe if it was
// written to a removed file.
void QueueThread::look_for_loss() {
  if (is_lost_) return;
  const std::string what = queue_.database().displaced();
  if (what.empty()) return;
  const std::string why =
      "the ledger is lost: " + what +
      "; the service neither accepts nor records anything until the ledger is put back and the service is restarted";
  queue_.database().look_only(why);
  is_lost_ = true;
  service_log(LogSeverity::kError, 0, "ALARM: " + why);
}

bool QueueThread::run_batch(std::vector<Task>& batch) {
  try {
    look_for_loss();
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
    if (is_lost_) return true;  // tasks that only read have succeeded
    look_for_loss();
    queue_.check_kept();
    transaction.commit();
    return true;
  } catch (...) {  // usually a full disk: nothing of the batch is committed
    bool is_no_space = says_no_space(std::current_exception());
    for (Task& task : batch) {
      is_no_space = is_no_space || says_no_space(task.error);
      if (!task.error) task.error = std::current_exception();
    }
    if (is_no_space) queue_.database().empty_log();  // may make room for the next batch
    try {
      queue_.resync();
    } catch (...) {  // the next batch then fails too
    }
    return false;
  }
}

}  // namespace multum
