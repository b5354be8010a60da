// SPDX-License-Identifier: Apache-2.0
// Sends the daemon's work to Slurm and follows it. The ledger records the work that Slurm has (slurm_notes.h); Slurm
// only dispatches it:
//
//   order() ─> estimate ─> note in the ledger ─> sbatch ─> look every `poll`: at squeue, at the shared folder
//                              ^                              │
//                              │ Slurm does not know it       ├─> a part has ended: ended()
//                              └──────────────────────────────┤
//                                                             └─> the ledger does not know it: scancel
//
// Work that sbatch refuses is sent again when Slurm accepts orders again, or in smaller arrays; otherwise it fails with
// sbatch's message.
//
// Runs on the thread of its io_context. Blocking calls have their own threads. Slurm's commands run one at a time.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "host/farm/service/ledger/queue_thread.h"
#include "host/farm/service/slurm/slurm_commands.h"
#include "host/farm/service/slurm/slurm_folder.h"
#include "host/farm/service/slurm/slurm_look.h"
#include "host/farm/service/slurm/slurm_plan.h"
#include "host/farm/service/slurm/slurm_settings.h"
#include "host/farm/service/workers/worker_pool.h"

namespace multum {

struct SlurmPoolSettings {
  SlurmSettings slurm;
  std::string instance;            // part of the names of the daemon's jobs at Slurm
  std::vector<std::string> roots;  // folders that jobs may read and write
  std::chrono::milliseconds lease{10000}, no_progress{600000}, cancel_grace{10000};  // times for workers on nodes
};

struct SlurmWork {
  WorkOrder order;   // the order's log collects the logs of nodes
  std::string made;  // the result under its staging name; shares are next to it
  std::int64_t memory_bytes = 0;
  int priority = 0;  // sum of the priorities of the job and its queue
};

class SlurmPool {
 public:
  struct Events {
    std::function<void(std::int64_t job, const JobProgress&)> progress;
    std::function<void(std::int64_t job, int attempt, const WorkResult& result)> ended;
  };
  struct Counters {
    std::uint64_t submitted = 0;  // number of Slurm jobs
    std::uint64_t submit_failures = 0;
    std::uint64_t forgotten = 0;          // parts that Slurm did not know, and that were sent again
    std::uint64_t cancelled_unknown = 0;  // parts that were unknown to the ledger
    std::uint64_t parts_ended = 0, parts_lost = 0, rounds = 0;
    double submit_seconds = 0.0;  // time spent on writing orders and running sbatch
  };
  /// The data of a running part that are not in its ledger record.
  struct PartView {
    std::string slurm_state, reason, node;
    JobProgress progress;
  };

  SlurmPool(boost::asio::io_context& io, QueueThread& ledger, SlurmPoolSettings settings, Events events);
  ~SlurmPool();
  SlurmPool(const SlurmPool&) = delete;
  SlurmPool& operator=(const SlurmPool&) = delete;

  /// Takes over the work that an earlier daemon has sent, as recorded in the ledger. Must be called before start().
  void adopt(const std::vector<SlurmWork>& works, const std::vector<SlurmPart>& parts, std::int64_t last_batch);
  /// Throws Error(kEnvironment) when the shared folder cannot be used.
  void start();
  /// Sends no more jobs. The work at Slurm continues.
  void close();

  /// Returns the number of further jobs that the pool accepts.
  int room() const;
  void order(SlurmWork work);
  /// Sends ordered jobs soon.
  void flush();
  /// Tells a job to stop. The job ends when Slurm reports its end. Returns false if the job is not in this pool.
  bool cancel(std::int64_t job);
  /// Ends the task of a share, which is then requested again. Returns false if no such task runs.
  bool cancel_part(std::int64_t job, std::int64_t batch, int item);
  std::optional<PartView> view(const SlurmPartKey& key) const;

  const Counters& counters() const { return counters_; }
  bool is_up() const { return is_up_; }
  std::map<std::string, int> states() const;  // counts unfinished parts by Slurm's states

 private:
  using Clock = std::chrono::steady_clock;
  struct Part {
    SlurmPart row;
    PartKind kind;
    PartView seen;
    std::uint64_t beat = 0;
    bool has_begun = false, is_cancelled = false;
    std::optional<Clock::time_point> heard;  // last sign of life while it runs
    std::optional<Clock::time_point> gone;   // the time from which on no Slurm task will do the part
  };
  enum class Stage { kNoting, kReady, kUnsure, kSending, kSent };  // kUnsure: Slurm may have it
  struct Batch {
    std::map<int, Part> parts;  // unfinished parts by item
    std::optional<std::int64_t> slurm_job;
    bool is_array = false, is_revoked = false;
    Stage stage = Stage::kNoting;
    int refusals = 0, waits = 0;  // number of sbatch's refusals for unknown and for temporary reasons
    int looks_to_skip = 0;        // number of checks to wait before the batch is sent again
    std::string refusal;          // sbatch's last message
    // If set, the batch is not sent. The value is the exit code of its parts.
    std::optional<int> refused_with;
    bool has_worked = false;  // at least one part has begun
    std::chrono::seconds time_max{0};
  };
  struct Work {
    SlurmWork work;
    SlurmEstimate estimate;
    int round = 1, share_count = 0, shares_done = 0, submissions = 0;
    bool have_inputs_changed = false;
    std::optional<WorkResult> result;  // reported when no part of the batch runs any more
    std::uint64_t given_up_in = 0;     // number of the check before the job was told to stop
  };
  struct Sending {
    std::int64_t number = 0;
    SlurmOrder order;
    SlurmSubmission submission;
    std::vector<std::int64_t> after;  // batches that may not have been sent yet
  };
  struct Sent {
    std::int64_t number = 0;
    std::optional<std::int64_t> slurm_job;
    std::string refusal;  // "" if the shared folder could not be written
  };

  std::string name_of(std::int64_t batch) const;
  std::string prefix() const;
  void beside(boost::asio::thread_pool& threads, std::function<std::function<void()>()> work);
  void note(QueueThread::Work work, std::function<void()> done);

  void estimate_new();
  void plan(std::vector<SlurmWork> works, std::vector<SlurmEstimate> estimates);
  void send(std::vector<std::vector<SlurmPart>> batches);
  void submit_ready();
  Sending sending_of(std::int64_t number, const Batch& batch) const;
  Sent submit(const Sending& sending, std::map<std::int64_t, std::int64_t>& known);
  void take_sent(const std::vector<Sent>& sent);
  void take_refusal(Batch& batch, const std::string& refusal);
  bool takes_smaller_arrays(const Batch& batch);
  void split_array(std::int64_t number);
  void replace(std::int64_t number, std::vector<std::vector<SlurmPart>> batches, const std::string& why);

  void stop_item(std::int64_t batch, int item);
  void cancel_tasks(std::vector<SlurmTarget> targets);
  void give_up(std::int64_t job, const WorkResult& result);
  void end_if_idle(std::int64_t job);

  // Functions in slurm_watch.cpp.
  enum class Fate { kGoesOn, kEnded, kAgain };  // kAgain: send it again
  void look();
  void digest(std::uint64_t look_number, const SlurmLook& look);
  std::vector<SlurmTarget> compare_lists(const SlurmLook& look);
  void follow_submission(Batch& batch);
  Fate follow(Batch& batch, Part& part, const SlurmLook::Seen& seen, const SlurmTask* task, std::uint64_t look_number,
              std::vector<SlurmTarget>& to_cancel);
  void follow_progress(Batch& batch, Part& part, const SlurmLook::Seen& seen);
  Fate follow_absence(Batch& batch, Part& part, const SlurmTask* task, const SlurmLook::Seen& seen);
  Fate end_part(Part& part, SlurmPartState state, const WorkResult& result);
  void settle(const std::vector<SlurmPart>& ended);
  void on_share_ended(Work& work, const SlurmPart& part, const WorkResult& result);
  void find_missing(std::int64_t job, const std::string& message);
  void begin_round(std::int64_t job, const std::vector<int>& missing, const std::string& message);
  void tell_progress(std::int64_t job);
  void send_again(std::int64_t number);
  void forget_empty_batches();
  bool has_parts(std::int64_t job) const;

  boost::asio::io_context& io_;
  QueueThread& ledger_;
  const SlurmPoolSettings settings_;
  const SlurmFolder folder_;
  const Events events_;
  std::atomic<bool> is_stopped_ = false;
  const SlurmCommands commands_;
  boost::asio::steady_timer timer_, gather_timer_;
  std::map<std::int64_t, Work> works_;
  std::map<std::int64_t, Batch> batches_;
  std::vector<std::int64_t> new_;
  std::map<SlurmPartKey, WorkResult> results_;      // results of parts whose end this check found
  std::map<std::int64_t, Clock::time_point> done_;  // batches, and when the last of their parts ended
  std::set<std::int64_t> cancelled_unknown_;        // unknown Slurm jobs that were cancelled
  std::int64_t last_batch_ = 0;
  int array_size_max_ = kAnyArraySize;  // Slurm's MaxArraySize, or a bound learned from refusals
  bool has_asked_array_size_ = false;
  std::uint64_t look_count_ = 0;
  bool is_gathering_ = false, is_looking_ = false, is_up_ = false, is_closed_ = false;
  Counters counters_;
  boost::asio::thread_pool commands_thread_{1}, estimates_threads_{2};  // last, because they use the members above
};

}  // namespace multum
