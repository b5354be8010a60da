// SPDX-License-Identifier: Apache-2.0
// Runs the one thread that uses the ledger. What many ask for at once is committed together: one sync of the disk
// serves all of them, and nobody is answered before it. A ledger that is removed or replaced meanwhile is only read
// from then on: what would be committed to it is in nobody's hands.
#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "host/farm/service/ledger/job_queue.h"

namespace multum {

class QueueThread {
 public:
  /// May throw: then nothing of it is done. May be run again, after what it did was undone with others' work.
  using Work = std::function<void(JobQueue&)>;
  using Done = std::function<void(std::exception_ptr)>;     // after the commit, by `post`; null: all is well
  using Post = std::function<void(std::function<void()>)>;  // runs a function on the caller's thread

  /// Opens the ledger; throws as JobQueue does.
  QueueThread(const LedgerSettings& settings, Post post);
  /// Does what was asked for, then ends.
  ~QueueThread();
  QueueThread(const QueueThread&) = delete;
  QueueThread& operator=(const QueueThread&) = delete;

  void run(Work work, Done done);
  /// Runs work and waits for it; rethrows. Not for the thread that `post` runs things on while others wait for it.
  void run_now(const Work& work);
  std::size_t pending() const;
  /// Is the ledger no longer in its place? All that would change it then throws Error(kEnvironment), until the next
  /// start.
  bool is_lost() const { return is_lost_; }

 private:
  struct Task {
    Work work;
    Done done;
    std::exception_ptr error;
    bool is_waited_for = false;  // `done` is called here, not by `post`
  };
  void add(Task task);
  void loop();
  /// False: nothing of it is done.
  bool run_batch(std::vector<Task>& batch);
  void look_for_loss();

  JobQueue queue_;
  Post post_;
  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<Task> tasks_;
  bool is_ending_ = false;
  std::atomic<bool> is_lost_ = false;
  std::thread thread_;
};

}  // namespace multum
