// SPDX-License-Identifier: Apache-2.0
// The ledger of jobs: what was accepted is there until it is purged, and each result is published once. Pure state: it
// starts nothing, waits for nothing, and is told the time. One thread uses it (queue_thread.h).
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

/// Limits of what runs at a time in a queue.
struct QueueLimits {
  int priority = 0;             // of the queue: before that of its jobs
  int jobs_max = 1 << 30;       // running at once
  std::int64_t memory_max = 0;  // of its running jobs together, bytes; 0: any
  bool is_paused = false;
  // Of whoever claims: only jobs of the types of this JSON list, or of all others; "": of all.
  std::string types = {};
  bool are_types_left = false;
};

struct ClaimLimits {
  std::map<std::string, QueueLimits> queues;  // jobs of others are not claimed
  std::map<std::string, int> device_jobs_max;
  std::int64_t memory_max = 0;  // of all jobs together that run on this machine; 0: any
};

struct RetryPolicy {
  TimeMs back_off_first = 1000;  // before the second attempt; doubled before each one after
  TimeMs back_off_max = 300000;
};

struct LedgerSettings {
  std::string path;       // of the database
  std::string results;    // folder whose files go with the jobs that made them, without links; "": none do
  std::string instance;   // name of the folder that it belongs to; "": any
  std::string numbers;    // file that says up to where numbers may have been given; "": none is kept
  bool may_begin = true;  // false: it must be there, and be this instance's
  RetryPolicy retry;
};

struct SubmitResult {
  std::int64_t id = 0;
  bool is_new = true;  // false: a job of this key and output was there
};

/// Result of an attempt.
struct AttemptResult {
  AttemptOutcome outcome = AttemptOutcome::kSucceeded;
  int exit_code = 0;
  std::string message;
};

enum class CancelResult { kCancelled, kStopWorker, kTooLate, kUnknown };

struct JobFilter {
  std::optional<JobState> state;
  std::string queue;                   // "": any
  std::optional<std::int64_t> before;  // ids below
  int limit = 100;                     // 1..1000
};

struct RetryResult {
  std::vector<std::int64_t> queued;  // it, what it needs and what died because of these; none: see `refusal`
  std::string refusal;
};

class JobQueue {
 public:
  /// Opens or creates the database. Throws as SqliteDatabase and prepare_ledger() do, and Error(kEnvironment) for
  /// another instance's ledger.
  explicit JobQueue(const LedgerSettings& settings);
  /// Name of the folder that the ledger belongs to; "": of none yet.
  const std::string& instance() const { return instance_; }
  /// The next job's number is above `number`, whoever has used the ones up to it. A new ledger's, and an old copy's
  /// that takes the place of a later one, are above LedgerSettings::numbers by itself.
  void number_above(std::int64_t number);
  /// Throws Error(kEnvironment) when what is submitted now would be lost.
  void check_kept() const { database_.check_may_change(); }

  /// A job of the same key and output that waits, runs, or whose result `is_intact`, is taken for the new one. Throws
  /// Error(kUsage) for needs that do not exist, or have failed for good.
  using IsIntact = std::function<bool(const Job& succeeded)>;
  SubmitResult submit(const JobSubmission& submission, const IsIntact& is_intact, TimeMs now);

  /// The job that comes first of those that may run, now running under a lease of `owner`'s; none: nothing may.
  std::optional<Job> claim(const ClaimLimits& limits, const std::string& owner, TimeMs now);
  /// When the next back-off or deadline of a job that does not run is over.
  std::optional<TimeMs> next_due();

  /// The lease's holder says that the result lies ready under its staging name. False: it is not the holder any more.
  bool begin_publishing(std::int64_t id, const std::string& owner, int attempt, const std::string& identity);
  /// The result has its name. Queues those that needed it.
  void published(std::int64_t id, TimeMs now);
  /// Removes a job's key: its inputs have changed since it was submitted, so that its result is another.
  void forget_key(std::int64_t id);
  /// An attempt ended otherwise, or without a result to publish. False: the holder is not the holder any more.
  bool ended(std::int64_t id, const std::string& owner, int attempt, const AttemptResult& result, TimeMs now);

  CancelResult cancel(std::int64_t id, const std::string& why, TimeMs now);
  /// A dead or cancelled job again; with it those of its needs that are dead or cancelled, down to the roots, and those
  /// that died because of any of these. Refused: it is neither, or one of its needs was purged.
  RetryResult retry(std::int64_t id, TimeMs now);
  /// Retries all dead jobs of one queue or of all, but for those that would be refused, whose message says why. Returns
  /// all that are queued again.
  std::vector<std::int64_t> retry_dead(const std::string& queue, TimeMs now);
  /// Jobs that may not start any more die; returns their ids, and those of running ones that are to be stopped.
  struct Overdue {
    std::vector<std::int64_t> dead, running;
  };
  Overdue expire_deadlines(TimeMs now);
  /// Forgets finished jobs that nothing unfinished needs, and notes what they leave. Returns their ids.
  std::vector<std::int64_t> purge(const std::vector<std::int64_t>& ids);
  std::vector<std::int64_t> purge_finished_before(TimeMs time, int limit);

  std::optional<Job> find(std::int64_t id);
  std::vector<Job> list(const JobFilter& filter);
  /// Bytes, about, of the texts of all that list() would find.
  std::int64_t list_bytes(const JobFilter& filter);
  std::vector<JobAttempt> attempts(std::int64_t id);
  /// "default" -> {queued -> 12, ...}.
  std::map<std::string, std::map<JobState, std::int64_t>> counts();
  /// A job that succeeded with this key, newest first; its output may have been changed since.
  std::vector<Job> succeeded_with_key(const std::string& key);
  void set_reused_from(std::int64_t id, std::int64_t from);

  /// Reads what is kept beside the database again, after an error has undone a transaction.
  void resync();

  /// Recovers after a start: what ran is lost and counts as an attempt; what was being published is returned, to be
  /// looked after.
  struct Recovered {
    std::vector<std::int64_t> lost;
    std::vector<Job> with_slurm;
    std::vector<Job> publishing;
  };
  /// `keeps_slurm`: what is with Slurm runs on.
  Recovered recover(TimeMs now, bool keeps_slurm = false);
  /// Notes that a job's result could not be published.
  void publishing_failed(std::int64_t id, const AttemptResult& result, TimeMs now);

  /// Whether the ledger gave a number to a job that has ended. Of numbers that it knows nothing of: no.
  struct Given {
    std::int64_t first = 0, last = 0;  // all of these numbers were given by it
    bool has(std::int64_t id) const { return first <= id && id <= last; }
  };
  struct Numbers {
    std::vector<std::int64_t> ended, unfinished;  // jobs that it has, in order
    Given given;
    bool is_finished_with(std::int64_t id) const;
  };
  Numbers numbers();
  bool was_purged(std::int64_t id);

  /// Back-offs that are longer than any can be, since the clock was set back, end now.
  void forgive_back_offs(TimeMs now);

  SqliteDatabase& database() { return database_; }
  FileNotes& files() { return files_; }
  SlurmNotes& slurm() { return slurm_; }
  /// Jobs whose state has changed since the last call.
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
    bool is_held_up = false;  // by the memory of all running jobs
  };
  std::optional<Candidate> first_candidate(const std::string& queue, const QueueLimits& limits, const ClaimLimits& all,
                                           TimeMs now);
  SqliteStatement& bind_filter(SqliteStatement& query, const JobFilter& filter);
  SqliteStatement& statement(const char* sql) { return database_.statement(sql); }
  std::vector<std::int64_t> needs_of(std::int64_t id);
  std::vector<std::int64_t> ids(SqliteStatement& query);

  /// Of running and publishing jobs, kept beside the database, which has the same.
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
  std::int64_t reserved_ = 0;  // numbers_ says so
  std::map<std::string, Use> queue_use_, device_use_;
  Use use_;
  std::set<std::int64_t> changed_;
};

}  // namespace multum
