// SPDX-License-Identifier: Apache-2.0
// Defines the ledger of jobs. The ledger keeps every accepted job until the job is purged, and lets each result be
// published only once. The ledger contains only state. It starts nothing, waits for nothing, and gets the time from its
// caller. Only one thread uses it (queue_thread.h).
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/farm/service/ledger/file_notes.h"
#include "host/farm/service/ledger/job.h"
#include "host/farm/service/ledger/slurm_notes.h"
#include "host/farm/service/ledger/sqlite_database.h"

namespace multum {

/// The limits of the jobs that run at the same time in a queue.
struct QueueLimits {
  int priority = 0;             // queues with higher values go first, whatever their jobs' priorities
  int jobs_max = 1 << 30;       // jobs that run at the same time
  std::int64_t memory_max = 0;  // bytes of its running jobs together; 0 means no limit
  bool is_paused = false;
  // Restricts a claim to jobs of the types in this JSON list, or to all other types. An empty text means all types.
  std::string types = {};
  bool are_types_left = false;
};

struct ClaimLimits {
  std::map<std::string, QueueLimits> queues;  // jobs of other queues are not claimed
  std::map<std::string, int> device_jobs_max;
  std::int64_t memory_max = 0;  // bytes of all jobs that run on this machine; 0 means no limit
};

struct RetryPolicy {
  TimeMs back_off_first = 1000;  // pause before the second attempt; doubles with each further attempt
  TimeMs back_off_max = 300000;
};

struct LedgerSettings {
  std::string path;       // file of the database
  std::string results;    // canonical path of the folder whose files are purged with their jobs; "" if none
  std::string instance;   // name of the folder that owns the ledger; "" means any
  std::string numbers;    // file with the highest number that jobs may have; "" if there is no such file
  bool may_begin = true;  // if false, the ledger must exist and belong to this instance
  RetryPolicy retry;
};

struct SubmitResult {
  std::int64_t id = 0;
  bool is_new = true;  // false if a job with this key and output existed
};

/// The end of an attempt.
struct AttemptResult {
  AttemptOutcome outcome = AttemptOutcome::kSucceeded;
  int exit_code = 0;
  std::string message;
};

enum class CancelResult { kCancelled, kStopWorker, kTooLate, kUnknown };

struct JobFilter {
  std::optional<JobState> state;
  std::string queue;                   // "" means any queue
  std::optional<std::int64_t> before;  // only ids below this one
  int limit = 100;                     // 1..1000
};

struct RetryResult {
  std::vector<std::int64_t> queued;  // the job, its needs, and jobs that died because of them; if empty, see `refusal`
  std::string refusal;
};

class JobQueue {
 public:
  /// Opens or creates the database. Throws like SqliteDatabase and prepare_ledger(). Throws Error(kEnvironment) for the
  /// ledger of another instance.
  explicit JobQueue(const LedgerSettings& settings);
  /// Returns the name of the folder that owns the ledger, or "" if no folder owns it yet.
  const std::string& instance() const { return instance_; }
  /// Makes the next job's number larger than `number`, even if this ledger has not used the numbers up to `number`. A
  /// new ledger, or a restored older copy, automatically skips the job numbers up to the number in the file
  /// LedgerSettings::numbers.
  void number_above(std::int64_t number);
  /// Throws Error(kEnvironment) if a job submitted now would be lost.
  void check_kept() const { database_.check_may_change(); }

  /// Adds a job. If a job of the same key and output already waits, runs, or has a result that `is_intact` accepts,
  /// returns that job instead. Throws Error(kUsage) for needs that do not exist or have failed permanently.
  using IsIntact = std::function<bool(const Job& succeeded)>;
  SubmitResult submit(const JobSubmission& submission, const IsIntact& is_intact, TimeMs now);

  /// Gives `owner` a lease on the first job that may run. Returns this job, or nullopt if no job may run.
  std::optional<Job> claim(const ClaimLimits& limits, const std::string& owner, TimeMs now);
  /// The earliest end of a back-off or deadline among jobs that do not run.
  std::optional<TimeMs> next_due();

  /// Records the report of a lease's holder that the result is ready under its staging name. Returns false if the
  /// caller no longer holds the lease.
  bool begin_publishing(std::int64_t id, const std::string& owner, int attempt, const std::string& identity);
  /// Records that the result has its final name. Queues the jobs that needed it.
  void published(std::int64_t id, TimeMs now);
  /// Removes the key of a job whose inputs have changed since it was submitted, because the key no longer describes its
  /// result.
  void forget_key(std::int64_t id);
  /// Records that an attempt failed, or ended without a result to publish. Returns false if `owner` no longer holds the
  /// lease.
  bool ended(std::int64_t id, const std::string& owner, int attempt, const AttemptResult& result, TimeMs now);

  CancelResult cancel(std::int64_t id, const std::string& why, TimeMs now);
  /// Queues a dead or cancelled job again. Also queues its dead or cancelled needs, recursively, and the jobs that died
  /// because of any of these. Refuses jobs in other states, and jobs with a purged need.
  RetryResult retry(std::int64_t id, TimeMs now);
  /// Retries all dead jobs of one queue or of all queues, except for jobs that retry() would refuse. The messages of
  /// these jobs give the reason. Returns all jobs that are queued again.
  std::vector<std::int64_t> retry_dead(const std::string& queue, TimeMs now);
  /// Marks jobs as dead if their deadline has passed. Returns the ids of these jobs, and of running jobs that must be
  /// stopped.
  struct Overdue {
    std::vector<std::int64_t> dead, running;
  };
  Overdue expire_deadlines(TimeMs now);
  /// Removes finished jobs that no unfinished job needs, and records the files that they leave behind. Returns the ids
  /// of the removed jobs.
  std::vector<std::int64_t> purge(const std::vector<std::int64_t>& ids);
  std::vector<std::int64_t> purge_finished_before(TimeMs time, int limit);

  std::optional<Job> find(std::int64_t id);
  std::vector<Job> list(const JobFilter& filter);
  /// The approximate bytes of the texts of all jobs that list() would return.
  std::int64_t list_bytes(const JobFilter& filter);
  std::vector<JobAttempt> attempts(std::int64_t id);
  /// Counts jobs by queue and state. An example is "default" -> {queued -> 12, ...}.
  std::map<std::string, std::map<JobState, std::int64_t>> counts();
  /// Returns jobs that succeeded with this key, the newest first. The outputs of these jobs may have changed since
  /// then.
  std::vector<Job> succeeded_with_key(const std::string& key);
  void set_reused_from(std::int64_t id, std::int64_t from);

  /// After an error has undone a transaction, reads the cached values from the database again.
  void resync();

  /// Recovers after a start. Marks running jobs as lost, which counts as an attempt. Returns jobs that were being
  /// published, which the caller must complete.
  struct Recovered {
    std::vector<std::int64_t> lost;
    std::vector<Job> with_slurm;
    std::vector<Job> publishing;
  };
  /// If `keeps_slurm`, jobs at Slurm stay running.
  Recovered recover(TimeMs now, bool keeps_slurm = false);
  /// Records that a job's result could not be published.
  void publishing_failed(std::int64_t id, const AttemptResult& result, TimeMs now);

  /// Tells which numbers belong to jobs that have ended. Numbers that the ledger did not give count as not ended.
  struct Given {
    std::int64_t first = 0, last = 0;  // the ledger gave all of these numbers
    bool has(std::int64_t id) const { return first <= id && id <= last; }
  };
  struct Numbers {
    std::vector<std::int64_t> ended, unfinished;  // jobs in the ledger, in order
    Given given;
    bool is_finished_with(std::int64_t id) const;
  };
  Numbers numbers();
  bool was_purged(std::int64_t id);

  /// Ends back-offs that are longer than the maximum, because the clock was set back.
  void forgive_back_offs(TimeMs now);

  SqliteDatabase& database() { return database_; }
  FileNotes& files() { return files_; }
  SlurmNotes& slurm() { return slurm_; }
  /// Returns the jobs whose state has changed since the last call.
  std::set<std::int64_t> take_changed() { return std::exchange(changed_, {}); }

 private:
  void requeue_or_die(const Job& job, const AttemptResult& result, TimeMs now);
  void set_state(std::int64_t id, JobState state, const std::string& message);
  void finish(std::int64_t id, JobState state, const std::string& message, TimeMs now);
  void fail_dependents(std::int64_t id, TimeMs now);
  void release_dependents(std::int64_t id);
  void queue_again(std::int64_t id, TimeMs now);
  std::string gone_need(std::int64_t id, std::vector<std::int64_t>& roots);
  bool may_wait(std::int64_t id);
  Given given();
  void settle_waiting(TimeMs now);
  void take_instance(const LedgerSettings& settings);
  void take_numbers();
  void reserve(std::int64_t id);
  void close_attempt(const Job& job, const AttemptResult& result, TimeMs now);
  bool has_lease(const std::optional<Job>& job, const std::string& owner, int attempt) const;
  struct Candidate {
    Job job;
    bool is_held_up = false;  // held up because the running jobs leave too little memory
  };
  std::optional<Candidate> first_candidate(const std::string& queue, const QueueLimits& limits, const ClaimLimits& all,
                                           TimeMs now);
  SqliteStatement& bind_filter(SqliteStatement& query, const JobFilter& filter);
  SqliteStatement& statement(const char* sql) { return database_.statement(sql); }
  std::vector<std::int64_t> needs_of(std::int64_t id);
  std::vector<std::int64_t> ids(SqliteStatement& query);

  /// The resources that running and publishing jobs use. This is a copy of data in the database.
  struct Use {
    int jobs = 0;
    std::int64_t memory = 0;
  };
  void count_use(const Job& job, int sign);

  SqliteDatabase database_;
  FileNotes files_{database_};
  SlurmNotes slurm_{database_};
  RetryPolicy policy_;
  std::string results_, instance_, numbers_;
  std::int64_t reserved_ = 0;  // the number in the file numbers_
  std::map<std::string, Use> queue_use_, device_use_;
  Use use_;
  std::set<std::int64_t> changed_;
};

}  // namespace multum
