// SPDX-License-Identifier: Apache-2.0
// The daemon's side of what it sends to Slurm. The ledger says what is there (slurm_notes.h); Slurm only dispatches:
//
//   order() ─> estimate ─> note in the ledger ─> sbatch ─> look every `poll`: at squeue, at the shared folder
//                              ^                              │
//                              │ Slurm does not know it       ├─> a part has ended: ended()
//                              └──────────────────────────────┤
//                                                             └─> Slurm has what the ledger does not: scancel
//
// What sbatch refuses is sent again when Slurm takes orders again, or in smaller arrays; or it ends, with sbatch's
// words.
//
// On the thread of its io_context; what blocks runs on threads of its own, Slurm's commands one after the other.
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
  std::string instance;            // in the names of its jobs at Slurm
  std::vector<std::string> roots;  // that jobs may read and write
  std::chrono::milliseconds lease{10000}, no_progress{600000}, cancel_grace{10000};  // of workers on nodes
};

struct SlurmWork {
  WorkOrder order;   // its log: where what nodes log is gathered
  std::string made;  // its result before it has its name; shares lie beside it
  std::int64_t memory_bytes = 0;
  int priority = 0;  // of job and queue
};

class SlurmPool {
 public:
  struct Events {
    std::function<void(std::int64_t job, const JobProgress&)> progress;
    std::function<void(std::int64_t job, int attempt, const WorkResult& result)> ended;
  };
  struct Counters {
    std::uint64_t submitted = 0;  // jobs of Slurm's
    std::uint64_t submit_failures = 0;
    std::uint64_t forgotten = 0;          // that Slurm did not know any more, sent again
    std::uint64_t cancelled_unknown = 0;  // that the ledger did not know
    std::uint64_t parts_ended = 0, parts_lost = 0, rounds = 0;
    double submit_seconds = 0.0;  // of sbatch, and of writing what it is to do
  };
  /// What is known of a part that runs, beside its note in the ledger.
  struct PartView {
    std::string slurm_state, reason, node;
    JobProgress progress;
  };

  SlurmPool(boost::asio::io_context& io, QueueThread& ledger, SlurmPoolSettings settings, Events events);
  ~SlurmPool();
  SlurmPool(const SlurmPool&) = delete;
  SlurmPool& operator=(const SlurmPool&) = delete;

  /// What an earlier daemon has sent, by the ledger. Before start().
  void adopt(const std::vector<SlurmWork>& works, const std::vector<SlurmPart>& parts, std::int64_t last_batch);
  /// Throws Error(kEnvironment) when the shared folder cannot be used.
  void start();
  /// Nothing is sent any more; what Slurm has goes on.
  void close();

  /// How many jobs more it takes.
  int room() const;
  void order(SlurmWork work);
  /// Sends what was ordered, soon.
  void flush();
  /// Asks a job to stop: it ends as Slurm says so. False: it is not here.
  bool cancel(std::int64_t job);
  /// Ends the task of a share, which is then asked for again. False: there is none that runs.
  bool cancel_part(std::int64_t job, std::int64_t batch, int item);
  std::optional<PartView> view(const SlurmPartKey& key) const;

  const Counters& counters() const { return counters_; }
  bool is_up() const { return is_up_; }
  std::map<std::string, int> states() const;  // of parts that have not ended, by Slurm's states

 private:
  using Clock = std::chrono::steady_clock;
  struct Part {
    SlurmPart row;
    PartKind kind;
    PartView seen;
    std::uint64_t beat = 0;
    bool has_begun = false, is_cancelled = false;
    std::optional<Clock::time_point> heard;  // while it runs
    std::optional<Clock::time_point> gone;   // since when Slurm has no task for it that will do it
  };
  enum class Stage { kNoting, kReady, kUnsure, kSending, kSent };  // kUnsure: perhaps Slurm has it
  struct Batch {
    std::map<int, Part> parts;  // by item; those that have not ended
    std::optional<std::int64_t> slurm_job;
    bool is_array = false, is_revoked = false;
    Stage stage = Stage::kNoting;
    int refusals = 0, waits = 0;  // of sbatch: for reasons unknown; because it was not the moment
    int looks_to_skip = 0;        // before it is sent again
    std::string refusal;          // what it said last
    // It will not be sent: exit code of its parts.
    std::optional<int> refused_with;
    bool has_worked = false;  // some part of it has begun
    std::chrono::seconds time_max{0};
  };
  struct Work {
    SlurmWork work;
    SlurmEstimate estimate;
    int round = 1, share_count = 0, shares_done = 0, submissions = 0;
    bool have_inputs_changed = false;
    std::optional<WorkResult> result;  // as soon as nothing of it runs any more
    std::uint64_t given_up_in = 0;     // the look before it was asked to stop
  };
  struct Sending {
    std::int64_t number = 0;
    SlurmOrder order;
    SlurmSubmission submission;
    std::vector<std::int64_t> after;  // batches that are not known to be sent
  };
  struct Sent {
    std::int64_t number = 0;
    std::optional<std::int64_t> slurm_job;
    std::string refusal;  // "": the shared folder could not be written
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

  // slurm_watch.cpp
  enum class Fate { kGoesOn, kEnded, kAgain };  // kAgain: to be sent again
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
  std::map<SlurmPartKey, WorkResult> results_;      // of parts that have ended in this look
  std::map<std::int64_t, Clock::time_point> done_;  // batches, when all of their parts had ended
  std::set<std::int64_t> cancelled_unknown_;        // Slurm's jobs
  std::int64_t last_batch_ = 0;
  int array_size_max_ = kAnyArraySize;  // Slurm's MaxArraySize, as far as it is known
  bool has_asked_array_size_ = false;
  std::uint64_t look_count_ = 0;
  bool is_gathering_ = false, is_looking_ = false, is_up_ = false, is_closed_ = false;
  Counters counters_;
  boost::asio::thread_pool commands_thread_{1}, estimates_threads_{2};  // last: they use what is above
};

}  // namespace multum
