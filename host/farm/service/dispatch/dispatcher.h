// SPDX-License-Identifier: Apache-2.0
// Brings jobs and workers together. Claims jobs for idle workers, publishes results, records how jobs ended, and wakes
// up when a back-off or a deadline has passed. Runs on the thread of its io_context, which also receives the ledger's
// answers.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <functional>
#include <map>
#include <set>
#include <string>

#include "host/farm/service/dispatch/data_folder.h"
#include "host/farm/service/dispatch/event_hub.h"
#include "host/farm/service/dispatch/service_settings.h"
#include "host/farm/service/files/job_roots.h"
#include "host/farm/service/files/staging.h"
#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/ledger/queue_thread.h"
#include "host/farm/service/slurm/slurm_pool.h"
#include "host/farm/service/workers/worker_pool.h"

namespace multum {

/// Returns whether a succeeded job's result is unchanged since it was published.
bool is_result_intact(const JobRoots& roots, const Job& job);

class Dispatcher {
 public:
  struct Counters {
    std::uint64_t succeeded = 0, failed = 0, lost = 0, reused = 0, published = 0, cancelled = 0;
    double busy_seconds = 0.0;  // sum over all workers
  };

  /// `worker_command` is the command line of a worker, without its socket. Results are published below the output
  /// roots. `data` counts the results in its folder. While this folder is full, jobs whose results belong there do not
  /// start.
  Dispatcher(boost::asio::io_context& io, QueueThread& ledger, EventHub& events, DataFolder& data,
             ServiceSettings settings, const JobRoots& roots, std::string instance,
             std::vector<std::string> worker_command);

  /// Recovers the jobs of an earlier daemon. Must be called before anything starts. Blocks.
  void recover();
  void start();
  /// Must be called whenever there may be work.
  void pump();
  /// Must be called when other code has changed jobs. Tells listeners, and looks for work.
  void changed(const std::set<std::int64_t>& ids);
  /// Tells the worker of a running job to stop. The attempt ends with `outcome`.
  void stop_job(std::int64_t id, const std::string& why, AttemptOutcome outcome);
  void set_paused(const std::string& queue, bool is_paused);
  /// Applies new limits from the settings.
  void reload(const ServiceSettings& settings);
  /// Starts no more jobs. Calls `done` when no job is running, or after the grace period at the latest. Jobs that are
  /// still running at that time are handed back to the queue.
  void drain(std::function<void()> done);

  const std::map<std::int64_t, JobProgress>& progress() const { return progress_; }
  const Counters& counters() const { return counters_; }
  const WorkerPool& workers() const { return pool_; }
  /// This pointer is null if no jobs are sent to Slurm.
  SlurmPool* slurm() const { return slurm_.get(); }
  bool uses_slurm(const std::string& queue) const;  // whether Slurm runs at least one job type of this queue
  bool goes_to_slurm(const std::string& queue, const std::string& type) const;
  /// Returns whether any job runs on this machine, or false if Slurm runs all jobs.
  bool bakes_here() const;
  const ClaimLimits& limits() const { return limits_; }
  bool is_draining() const { return is_draining_; }
  std::string log_path(std::int64_t id) const;
  void remove_logs(const std::vector<std::int64_t>& ids) const;
  const std::string& instance() const { return instance_; }
  /// Removes the staging folder of a job that will not be run. Blocks.
  void remove_staging(const Job& job) const;

 private:
  struct Claimed {
    Job job;
    std::string copy_from;  // a finished result with the same key
  };
  /// Changes made by one unit of work in the ledger, and the jobs that this unit claimed at the same time.
  struct Outcome {
    std::vector<Job> touched;
    std::vector<Claimed> claimed;
    std::optional<TimeMs> due;
  };
  /// Records changes, and claims jobs for these workers. Runs on the ledger's thread.
  void settle(JobQueue& queue, const ClaimLimits& limits, const std::vector<std::string>& owners,
              Outcome& outcome) const;
  /// Tells listeners, and starts the claimed jobs. Runs afterwards, on the dispatcher's thread.
  void take(const std::vector<std::string>& owners, const Outcome& outcome);
  void end_drain_if_idle();
  /// Runs `work` in the ledger, and repeats it while the disk is full until it is committed. Then runs `done`.
  void note(std::int64_t id, QueueThread::Work work, std::function<void()> done);
  void finish_publishing(const Job& job, const std::string& identity);
  std::vector<std::string> reserve(const std::vector<std::string>& owners);
  void give_out(const std::vector<Claimed>& claimed);
  void start_job(const Claimed& claimed);
  WorkOrder order_of(const Job& job, std::string& made) const;
  SlurmWork slurm_work(const Job& job, WorkOrder order, std::string made) const;
  void adopt(const std::vector<Job>& jobs, const std::vector<SlurmPart>& parts, std::int64_t last_batch);
  ClaimLimits limits_here() const;
  ClaimLimits limits_of_slurm() const;
  struct Claims {
    bool is_under_way = false;
    bool is_wanted = false;  // a claim must run again, because of later changes
  };
  void claim_here();
  void claim_for_slurm();
  void claim(Claims& claims, std::vector<std::string> owners, ClaimLimits limits, void (Dispatcher::*again)());
  void on_ended(std::int64_t id, const std::string& owner, int attempt, const WorkResult& result);
  void publish_result(std::int64_t id, const std::string& owner, int attempt, bool have_inputs_changed);
  /// Runs on the ledger's thread. Throws like StagedResult::publish().
  void publish(const Job& job, const std::string& identity) const;
  void forget_running(std::int64_t id, AttemptOutcome outcome);
  void note_end(std::int64_t id, const std::string& owner, int attempt, AttemptResult result);
  void on_progress(std::int64_t id, const JobProgress& progress);
  void wake_at(std::optional<TimeMs> due);
  void on_due();
  Claimed with_reuse(JobQueue& queue, Job job) const;
  StagedResult staged(const Job& job) const;

  boost::asio::io_context& io_;
  QueueThread& ledger_;
  EventHub& events_;
  DataFolder& data_;
  ServiceSettings settings_;
  const JobRoots& roots_;
  std::string instance_;
  ClaimLimits limits_;
  WorkerPool pool_;
  std::unique_ptr<SlurmPool> slurm_;
  boost::asio::steady_timer due_timer_, drain_timer_;
  std::map<std::int64_t, JobProgress> progress_;
  struct Running {
    Job job;
    std::chrono::steady_clock::time_point since;
    std::optional<AttemptResult> stop;  // why the job was told to stop
  };
  std::map<std::int64_t, Running> running_;
  std::set<std::string> reserved_;  // workers for which a claim is under way
  Claims claims_here_, slurm_claims_;
  bool is_draining_ = false;
  int unsettled_ = 0;  // ends and publications that are not yet in the ledger
  std::function<void()> drained_;
  Counters counters_;
};

}  // namespace multum
