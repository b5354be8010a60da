// SPDX-License-Identifier: Apache-2.0
// Runs the only thread that uses the ledger. Concurrent requests are committed together. One disk sync serves all of
// them, and none is answered before that sync. If the ledger's file is removed or replaced, the ledger becomes
// read-only, because commits would be lost.
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
  /// The work may throw, and its changes are then undone. The work may run again if its changes were undone together
  /// with those of other work.
  using Work = std::function<void(JobQueue&)>;
  using Done = std::function<void(std::exception_ptr)>;     // called after the commit, through `post`; null means
                                                            // success
  using Post = std::function<void(std::function<void()>)>;  // runs a function on the caller's thread

  /// Opens the ledger. Throws like JobQueue.
  QueueThread(const LedgerSettings& settings, Post post);
  /// Finishes all requested work, and then ends the thread.
  ~QueueThread();
  QueueThread(const QueueThread&) = delete;
  QueueThread& operator=(const QueueThread&) = delete;

  void run(Work work, Done done);
  /// Runs work, waits for it and rethrows its exception. Must not be called on the thread of `post`.
  void run_now(const Work& work);
  std::size_t pending() const;
  /// Returns whether the ledger's file was removed or replaced. All changes then throw Error(kEnvironment) until the
  /// next start.
  bool is_lost() const { return is_lost_; }

 private:
  struct Task {
    Work work;
    Done done;
    std::exception_ptr error;
    bool is_waited_for = false;  // `done` is called on this thread, not through `post`
  };
  void add(Task task);
  void loop();
  /// Returns false if nothing was committed.
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
