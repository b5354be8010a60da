// SPDX-License-Identifier: Apache-2.0
#include "host/farm/service/ledger/job_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fstream>

#include "host/farm/service/files/no_space.h"
#include "host/farm/service/ledger/ledger_schema.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/path_text.h"

namespace multum {
namespace {

constexpr std::int64_t kReservedAtOnce = 256;

constexpr int number_of(JobState state) { return static_cast<int>(state); }

}  // namespace

JobQueue::JobQueue(const LedgerSettings& settings)
    : database_(settings.path), policy_(settings.retry), results_(settings.results), numbers_(settings.numbers) {
  prepare_ledger(database_, settings.may_begin);
  if (const std::string damage = database_.damage(); !damage.empty())
    throw Error(
        ErrorCode::kInput,
        fmt::format("{}: is damaged: {}. docs/reference/service.md explains how to repair it", settings.path, damage));
  take_instance(settings);
  take_numbers();
  resync();
}

void JobQueue::take_instance(const LedgerSettings& settings) {
  SqliteStatement& known = statement("SELECT value FROM meta WHERE name = 'instance'");
  if (known.step()) instance_ = known.text(0);
  known.reset();
  if (instance_.empty() && !settings.instance.empty()) {
    statement("INSERT INTO meta (name, value) VALUES ('instance', ?)").bind(1, settings.instance).run();
    instance_ = settings.instance;
  } else if (!settings.may_begin && instance_ != settings.instance) {
    throw Error(ErrorCode::kEnvironment,
                fmt::format("{}: is the ledger of instance {}, expected the ledger of instance {}: {}", settings.path,
                            instance_, settings.instance, lost_ledger_advice()));
  }
}

void JobQueue::number_above(std::int64_t number) {
  if (number <= given().last) return;
  statement("INSERT INTO sqlite_sequence (name, seq) SELECT 'jobs', 0 WHERE NOT EXISTS (SELECT 1 FROM sqlite_sequence)")
      .run();
  statement("UPDATE sqlite_sequence SET seq = ? WHERE name = 'jobs'").bind(1, number).run();
  statement("INSERT OR REPLACE INTO meta (name, value) VALUES ('first_number', ?)").bind(1, number + 1).run();
}

void JobQueue::take_numbers() {
  if (numbers_.empty()) return;
  std::ifstream(numbers_) >> reserved_;
  const std::int64_t last = given().last;
  const bool is_new = last == 0 && reserved_ > 0, is_older = last + kReservedAtOnce < reserved_;
  if (is_new || is_older) number_above(reserved_);
}

void JobQueue::reserve(std::int64_t id) {
  if (numbers_.empty() || id <= reserved_) return;
  // The file is not synced. It is needed only if the ledger is lost, and it need not survive a power cut at the same
  // time.
  const std::int64_t last = id + kReservedAtOnce - 1;
  const std::string fresh = numbers_ + ".new";
  std::ofstream file(fresh);
  file << last << "\n" << std::flush;
  if (!file || std::rename(fresh.c_str(), numbers_.c_str()) != 0) {
    const int error = errno;
    std::remove(fresh.c_str());
    errno = error;
    fail_to_write(numbers_, "cannot be written");
  }
  reserved_ = last;
}

std::vector<std::int64_t> JobQueue::ids(SqliteStatement& query) {
  std::vector<std::int64_t> list;
  while (query.step()) list.push_back(query.integer(0));
  return list;
}

void JobQueue::count_use(const Job& job, int sign) {
  const auto count = [&](Use& use) {
    use.jobs += sign;
    use.memory += sign * job.memory_bytes;
  };
  count(queue_use_[job.queue]);
  count(device_use_[job.device]);
  if (!is_slurm_owner(job.owner)) count(use_);
}

void JobQueue::resync() {
  queue_use_.clear();
  device_use_.clear();
  use_ = Use{};
  static const std::string sql = select_jobs("WHERE state IN (2, 3)");
  SqliteStatement& query = statement(sql.c_str());
  while (query.step()) count_use(job_from_row(query), 1);
}

// ---- Submission

SubmitResult JobQueue::submit(const JobSubmission& s, const IsIntact& is_intact, TimeMs now) {
  check_kept();
  if (!s.key.empty()) {
    // Skips jobs that are about to be cancelled.
    static const std::string sql = select_jobs(
        "WHERE key = ? AND output = ? AND state < 5 AND key <> '' AND (stop_asked = '' OR state = 4) ORDER BY id DESC "
        "LIMIT 1");
    SqliteStatement& same = statement(sql.c_str());
    same.bind(1, s.key).bind(2, text_of_path(s.output));
    if (same.step()) {
      const Job job = job_from_row(same);
      same.reset();
      if (job.state != JobState::kSucceeded || is_intact(job)) return {job.id, false};
    }
  }
  std::set<std::int64_t> needs(s.needs.begin(), s.needs.end());
  int needs_left = 0;
  for (const std::int64_t id : needs) {
    const std::optional<Job> needed = find(id);
    if (!needed) throw Error(ErrorCode::kUsage, fmt::format("needs job {}, which does not exist", id));
    if (needed->state == JobState::kDead || needed->state == JobState::kCancelled)
      throw Error(ErrorCode::kUsage, fmt::format("needs job {}, which is {}", id, job_state_name(needed->state)));
    needs_left += needed->state != JobState::kSucceeded ? 1 : 0;
  }
  Job job;
  static_cast<JobSubmission&>(job) = s;
  job.state = needs_left > 0 ? JobState::kWaiting : JobState::kQueued;
  job.needs_left = needs_left;
  job.created = now;
  const std::int64_t id = insert_job(database_, job);
  reserve(id);
  for (const std::int64_t needed : needs)
    statement("INSERT INTO needs (job, needs) VALUES (?, ?)").bind(1, id).bind(2, needed).run();
  changed_.insert(id);
  return {id, true};
}

// ---- Leases

std::optional<JobQueue::Candidate> JobQueue::first_candidate(const std::string& queue, const QueueLimits& limits,
                                                             const ClaimLimits& all, TimeMs now) {
  const Use& used = queue_use_[queue];
  if (limits.is_paused || used.jobs >= limits.jobs_max) return std::nullopt;
  static const std::string sql = select_jobs(
      "WHERE queue = ?1 AND state = 1 AND (not_before IS NULL OR not_before <= ?2) AND (?3 = '' OR (type IN (SELECT "
      "value FROM json_each(?3))) <> ?4) ORDER BY priority DESC, id");
  SqliteStatement& query = statement(sql.c_str());
  query.bind(1, queue).bind(2, now).bind(3, limits.types).bind(4, limits.are_types_left ? 1 : 0);
  std::optional<Candidate> found;
  while (!found && query.step()) {
    Job job = job_from_row(query);
    // Skips jobs of busy devices, but waits for memory, because otherwise large jobs would never start. A job that
    // exceeds a limit by itself runs when no other job is running.
    const auto device = all.device_jobs_max.find(job.device);
    if (device != all.device_jobs_max.end() && device_use_[job.device].jobs >= device->second) continue;
    const auto fits = [&](const Use& use, std::int64_t memory_max) {
      return memory_max <= 0 || use.jobs == 0 || use.memory + job.memory_bytes <= memory_max;
    };
    if (!fits(used, limits.memory_max)) break;
    const bool is_held_up = !fits(use_, all.memory_max);
    found = Candidate{std::move(job), is_held_up};
  }
  query.reset();
  return found;
}

std::optional<Job> JobQueue::claim(const ClaimLimits& limits, const std::string& owner, TimeMs now) {
  std::optional<Candidate> first;
  int first_priority = 0;
  for (const auto& [name, of_queue] : limits.queues) {
    std::optional<Candidate> candidate = first_candidate(name, of_queue, limits, now);
    if (!candidate) continue;
    const auto rank = [](int queue, const Job& of) { return std::tuple(-queue, -of.priority, of.id); };
    if (first && rank(first_priority, first->job) < rank(of_queue.priority, candidate->job)) continue;
    first = std::move(candidate);
    first_priority = of_queue.priority;
  }
  // Small jobs of other queues must not overtake a large job either, because the large job would wait as long as small
  // jobs keep coming.
  if (!first || first->is_held_up) return std::nullopt;
  std::optional<Job> best = std::move(first->job);
  best->state = JobState::kRunning;
  best->owner = owner;
  ++best->attempt;
  best->started = now;
  best->needs = needs_of(best->id);
  statement(
      "UPDATE jobs SET state = 2, owner = ?, attempt = ?, attempts_counted = attempts_counted + 1, started = ?, "
      "not_before = NULL, message = '', exit_code = NULL, reused_from = NULL WHERE id = ?")
      .bind(1, owner)
      .bind(2, best->attempt)
      .bind(3, now)
      .bind(4, best->id)
      .run();
  statement("INSERT INTO attempts (job, number, owner, outcome, started) VALUES (?, ?, ?, 0, ?)")
      .bind(1, best->id)
      .bind(2, best->attempt)
      .bind(3, owner)
      .bind(4, now)
      .run();
  count_use(*best, 1);
  changed_.insert(best->id);
  return best;
}

std::optional<TimeMs> JobQueue::next_due() {
  // Names the indices in the query. Otherwise SQLite would use the index of states and read all queued jobs.
  SqliteStatement& query = statement(
      "SELECT MIN(t) FROM (SELECT MIN(not_before) AS t FROM jobs INDEXED BY jobs_back_off WHERE not_before IS NOT NULL "
      "AND state = 1 UNION ALL SELECT MIN(deadline) FROM jobs INDEXED BY jobs_deadline WHERE deadline IS NOT NULL AND "
      "state < 4 AND state <> 3)");
  query.step();
  const std::optional<TimeMs> due = query.optional_integer(0);
  query.reset();
  return due;
}

bool JobQueue::has_lease(const std::optional<Job>& job, const std::string& owner, int attempt) const {
  return job && job->state == JobState::kRunning && job->owner == owner && job->attempt == attempt;
}

bool JobQueue::begin_publishing(std::int64_t id, const std::string& owner, int attempt, const std::string& identity) {
  if (!has_lease(find(id), owner, attempt)) return false;
  statement("UPDATE jobs SET state = 3, result_identity = ? WHERE id = ?").bind(1, identity).bind(2, id).run();
  changed_.insert(id);
  return true;
}

void JobQueue::forget_key(std::int64_t id) {
  statement("UPDATE jobs SET key = '', reused_from = NULL WHERE id = ?").bind(1, id).run();
}

void JobQueue::published(std::int64_t id, TimeMs now) {
  const std::optional<Job> job = find(id);
  MULTUM_CHECK(job && job->state == JobState::kPublishing);
  close_attempt(*job, {AttemptOutcome::kSucceeded, 0, ""}, now);
  finish(id, JobState::kSucceeded, "", now);
  release_dependents(id);
}

void JobQueue::publishing_failed(std::int64_t id, const AttemptResult& result, TimeMs now) {
  const std::optional<Job> job = find(id);
  MULTUM_CHECK(job && job->state == JobState::kPublishing);
  close_attempt(*job, result, now);
  requeue_or_die(*job, result, now);
}

bool JobQueue::ended(std::int64_t id, const std::string& owner, int attempt, const AttemptResult& result, TimeMs now) {
  const std::optional<Job> job = find(id);
  if (!has_lease(job, owner, attempt)) return false;
  close_attempt(*job, result, now);
  switch (result.outcome) {
    case AttemptOutcome::kSucceeded:
      finish(id, JobState::kSucceeded, result.message, now);
      release_dependents(id);
      break;
    case AttemptOutcome::kCancelled:
      finish(id, JobState::kCancelled, result.message, now);
      fail_dependents(id, now);
      break;
    default: requeue_or_die(*job, result, now);
  }
  return true;
}

void JobQueue::close_attempt(const Job& job, const AttemptResult& result, TimeMs now) {
  count_use(job, -1);
  statement("UPDATE attempts SET outcome = ?, ended = ?, exit_code = ?, message = ? WHERE job = ? AND number = ?")
      .bind(1, static_cast<int>(result.outcome))
      .bind(2, now)
      .bind(3, result.exit_code)
      .bind(4, result.message)
      .bind(5, job.id)
      .bind(6, job.attempt)
      .run();
  statement("UPDATE jobs SET exit_code = ? WHERE id = ?").bind(1, result.exit_code).bind(2, job.id).run();
}

void JobQueue::requeue_or_die(const Job& job, const AttemptResult& result, TimeMs now) {
  if (!job.stop_asked.empty()) {
    finish(job.id, JobState::kCancelled, job.stop_asked, now);
    fail_dependents(job.id, now);
    return;
  }
  const bool is_counted = result.outcome != AttemptOutcome::kReturned;
  const int counted = job.attempts_counted - (is_counted ? 0 : 1);
  statement("UPDATE jobs SET attempts_counted = ? WHERE id = ?").bind(1, counted).bind(2, job.id).run();
  if (result.outcome == AttemptOutcome::kRefused || counted >= job.attempt_max) {
    finish(job.id, JobState::kDead, result.message, now);
    fail_dependents(job.id, now);
    return;
  }
  std::optional<TimeMs> not_before;
  if (is_counted) {
    TimeMs back_off = policy_.back_off_first;
    for (int i = 1; i < counted && back_off < policy_.back_off_max; ++i) back_off *= 2;
    not_before = now + std::min(policy_.back_off_max, back_off);
  }
  statement("UPDATE jobs SET state = 1, owner = '', not_before = ?, message = ? WHERE id = ?")
      .bind(1, not_before)
      .bind(2, result.message)
      .bind(3, job.id)
      .run();
  changed_.insert(job.id);
}

// ---- Ends, retries and purges

void JobQueue::set_state(std::int64_t id, JobState state, const std::string& message) {
  statement("UPDATE jobs SET state = ?, owner = '', message = ? WHERE id = ?")
      .bind(1, number_of(state))
      .bind(2, message)
      .bind(3, id)
      .run();
  changed_.insert(id);
}

void JobQueue::finish(std::int64_t id, JobState state, const std::string& message, TimeMs now) {
  set_state(id, state, message);
  statement("UPDATE jobs SET finished = ?, not_before = NULL WHERE id = ?").bind(1, now).bind(2, id).run();
}

void JobQueue::release_dependents(std::int64_t id) {
  SqliteStatement& waiting =
      statement("SELECT job FROM needs JOIN jobs ON jobs.id = needs.job WHERE needs.needs = ? AND jobs.state = 0");
  waiting.bind(1, id);
  for (const std::int64_t job : ids(waiting)) {
    statement(
        "UPDATE jobs SET needs_left = needs_left - 1, state = CASE needs_left WHEN 1 THEN 1 ELSE 0 END WHERE id = ?")
        .bind(1, job)
        .run();
    changed_.insert(job);
  }
}

void JobQueue::fail_dependents(std::int64_t id, TimeMs now) {
  std::vector<std::int64_t> failed = {id};
  while (!failed.empty()) {
    const std::int64_t cause = failed.back();
    failed.pop_back();
    SqliteStatement& waiting =
        statement("SELECT job FROM needs JOIN jobs ON jobs.id = needs.job WHERE needs.needs = ? AND jobs.state = 0");
    waiting.bind(1, cause);
    const std::string why = fmt::format("needs job {}, which is {}", cause, job_state_name(find(cause)->state));
    for (const std::int64_t job : ids(waiting)) {
      finish(job, JobState::kDead, why, now);
      failed.push_back(job);
    }
  }
}

CancelResult JobQueue::cancel(std::int64_t id, const std::string& why, TimeMs now) {
  const std::optional<Job> job = find(id);
  if (!job) return CancelResult::kUnknown;
  if (job->state == JobState::kRunning) {
    // The ledger may not know yet that the attempt has failed. In this case, the job would be queued again.
    statement("UPDATE jobs SET stop_asked = ? WHERE id = ?").bind(1, why).bind(2, id).run();
    return CancelResult::kStopWorker;
  }
  if (job->state == JobState::kPublishing || is_final(job->state)) return CancelResult::kTooLate;
  finish(id, JobState::kCancelled, why, now);
  fail_dependents(id, now);
  return CancelResult::kCancelled;
}

// Collects in `roots` the job itself and, recursively, all of its needs that are dead or cancelled. If a need was
// purged, returns a description of it, and otherwise an empty text.
std::string JobQueue::gone_need(std::int64_t id, std::vector<std::int64_t>& roots) {
  std::set<std::int64_t> seen = {id};
  roots = {id};
  for (std::size_t i = 0; i < roots.size(); ++i) {
    const std::int64_t job = roots[i];
    SqliteStatement& needs = statement(
        "SELECT needs.needs, jobs.state FROM needs LEFT JOIN jobs ON jobs.id = needs.needs WHERE needs.job = ? AND "
        "(jobs.id IS NULL OR jobs.state >= 5)");
    needs.bind(1, job);
    std::optional<std::int64_t> gone;
    while (needs.step()) {
      const std::int64_t need = needs.integer(0);
      if (!needs.optional_integer(1)) gone = need;
      else if (seen.insert(need).second) roots.push_back(need);
    }
    if (gone) {
      const std::string what = fmt::format("needs job {}, which was purged", *gone);
      return job == id ? what : fmt::format("needs job {}, which {}", job, what);
    }
  }
  return "";
}

RetryResult JobQueue::retry(std::int64_t id, TimeMs now) {
  RetryResult result;
  const std::optional<Job> job = find(id);
  if (!job || (job->state != JobState::kDead && job->state != JobState::kCancelled)) {
    result.refusal = fmt::format("job {} is {}; only dead and cancelled jobs can be retried", id,
                                 job ? job_state_name(job->state) : "unknown");
    return result;
  }
  if (const std::string gone = gone_need(id, result.queued); !gone.empty())
    return {{}, fmt::format("job {} {}: the job cannot be retried; submit it again", id, gone)};
  for (const std::int64_t root : result.queued) queue_again(root, now);
  // Some jobs died without running because they need these jobs. They wait again, unless another need is missing or
  // their deadline has passed. Each such job is examined once per job that it needs.
  for (std::size_t i = 0; i < result.queued.size(); ++i) {
    SqliteStatement& dependents = statement(
        "SELECT job FROM needs JOIN jobs ON jobs.id = needs.job WHERE needs.needs = ? AND jobs.state = 5 AND "
        "jobs.attempts_counted = 0 AND (jobs.deadline IS NULL OR jobs.deadline > ?)");
    dependents.bind(1, result.queued[i]).bind(2, now);
    for (const std::int64_t dependent : ids(dependents)) {
      if (!may_wait(dependent)) continue;
      queue_again(dependent, now);
      result.queued.push_back(dependent);
    }
  }
  return result;
}

// Returns whether each of the job's needs has succeeded or can still succeed.
bool JobQueue::may_wait(std::int64_t id) {
  SqliteStatement& lacks = statement(
      "SELECT 1 FROM needs LEFT JOIN jobs ON jobs.id = needs.needs WHERE needs.job = ? AND (jobs.id IS NULL OR "
      "jobs.state >= 5) LIMIT 1");
  lacks.bind(1, id);
  const bool is_lacking = lacks.step();
  lacks.reset();
  return !is_lacking;
}

void JobQueue::queue_again(std::int64_t id, TimeMs now) {
  SqliteStatement& query = statement(
      "SELECT COUNT(*) FROM needs JOIN jobs ON jobs.id = needs.needs WHERE needs.job = ? AND jobs.state <> 4");
  query.bind(1, id).step();
  const auto needs_left = static_cast<int>(query.integer(0));
  query.reset();
  statement(
      "UPDATE jobs SET state = ?, needs_left = ?, attempts_counted = 0, not_before = NULL, finished = NULL, deadline = "
      "CASE WHEN deadline <= ? THEN NULL ELSE deadline END, message = '', exit_code = NULL, reused_from = NULL, "
      "result_identity = '', stop_asked = '' WHERE id = ?")
      .bind(1, number_of(needs_left > 0 ? JobState::kWaiting : JobState::kQueued))
      .bind(2, needs_left)
      .bind(3, now)
      .bind(4, id)
      .run();
  changed_.insert(id);
}

std::vector<std::int64_t> JobQueue::retry_dead(const std::string& queue, TimeMs now) {
  SqliteStatement& dead = statement("SELECT id FROM jobs WHERE state = 5 AND (?1 = '' OR queue = ?1) ORDER BY id");
  dead.bind(1, queue);
  std::vector<std::int64_t> retried;
  for (const std::int64_t id : ids(dead)) {
    if (find(id)->state != JobState::kDead) continue;  // was queued together with an earlier job
    RetryResult result = retry(id, now);
    if (result.queued.empty()) set_state(id, JobState::kDead, result.refusal);
    retried.insert(retried.end(), result.queued.begin(), result.queued.end());
  }
  std::sort(retried.begin(), retried.end());
  return retried;
}

JobQueue::Overdue JobQueue::expire_deadlines(TimeMs now) {
  Overdue overdue;
  SqliteStatement& query =
      statement("SELECT id FROM jobs WHERE deadline IS NOT NULL AND state < 4 AND deadline <= ? AND state <> 3");
  query.bind(1, now);
  for (const std::int64_t id : ids(query)) {
    const std::optional<Job> job = find(id);
    if (job->state == JobState::kRunning) {
      overdue.running.push_back(id);
      continue;
    }
    if (is_final(job->state)) continue;  // died when a job that it needs ended
    finish(id, JobState::kDead, "its deadline passed before the job could start", now);
    fail_dependents(id, now);
    overdue.dead.push_back(id);
  }
  return overdue;
}

std::vector<std::int64_t> JobQueue::purge(const std::vector<std::int64_t>& wanted) {
  std::vector<std::int64_t> purged;
  for (const std::int64_t id : wanted) {
    const std::optional<Job> job = find(id);
    if (!job || !is_final(job->state)) continue;
    SqliteStatement& query = statement(
        "DELETE FROM jobs WHERE id = ?1 AND NOT EXISTS (SELECT 1 FROM needs JOIN jobs AS other ON other.id = needs.job "
        "WHERE needs.needs = ?1 AND other.state < 4)");
    if (query.bind(1, id).run() == 0) continue;
    const bool is_ours = !results_.empty() && job->output.starts_with(results_ + "/");
    statement("INSERT OR REPLACE INTO left_overs (job, output, identity) VALUES (?, ?, ?)")
        .bind(1, id)
        .bind(2, is_ours ? text_of_path(job->output) : "")
        .bind(3, job->result_identity)
        .run();
    purged.push_back(id);
    changed_.insert(id);
  }
  return purged;
}

std::vector<std::int64_t> JobQueue::purge_finished_before(TimeMs time, int limit) {
  // Skips jobs that must stay, so that they do not use up the limit.
  SqliteStatement& query = statement(
      "SELECT id FROM jobs WHERE state >= 4 AND finished < ? AND NOT EXISTS (SELECT 1 FROM needs JOIN jobs AS other ON "
      "other.id = needs.job WHERE needs.needs = jobs.id AND other.state < 4) ORDER BY finished LIMIT ?");
  query.bind(1, time).bind(2, limit);
  return purge(ids(query));
}

void JobQueue::set_reused_from(std::int64_t id, std::int64_t from) {
  statement("UPDATE jobs SET reused_from = ? WHERE id = ?").bind(1, from).bind(2, id).run();
}

void JobQueue::forgive_back_offs(TimeMs now) {
  statement("UPDATE jobs SET not_before = ?1 WHERE state = 1 AND not_before > ?1 + ?2")
      .bind(1, now)
      .bind(2, policy_.back_off_max)
      .run();
}

// No job may wait for a job that has failed or does not exist. Such jobs occur in rescued ledgers, and in ledgers older
// than version 4.
void JobQueue::settle_waiting(TimeMs now) {
  SqliteStatement& query = statement(
      "SELECT needs.job, needs.needs FROM needs JOIN jobs ON jobs.id = needs.job LEFT JOIN jobs AS other ON other.id = "
      "needs.needs WHERE jobs.state = 0 AND (other.id IS NULL OR other.state >= 5)");
  std::vector<std::pair<std::int64_t, std::int64_t>> stuck;
  while (query.step()) stuck.emplace_back(query.integer(0), query.integer(1));
  for (const auto& [id, need] : stuck) {
    if (find(id)->state != JobState::kWaiting) continue;  // died together with another job
    const std::optional<Job> other = find(need);
    finish(id, JobState::kDead,
           fmt::format("needs job {}, which {}", need,
                       other ? std::string("is ") + job_state_name(other->state) : "was purged"),
           now);
    fail_dependents(id, now);
  }
  statement(
      "UPDATE jobs SET needs_left = (SELECT COUNT(*) FROM needs JOIN jobs AS other ON other.id = needs.needs WHERE "
      "needs.job = jobs.id AND other.state <> 4) WHERE state = 0")
      .run();
  statement("UPDATE jobs SET state = 1 WHERE state = 0 AND needs_left = 0").run();
}

JobQueue::Recovered JobQueue::recover(TimeMs now, bool keeps_slurm) {
  settle_waiting(now);
  Recovered recovered;
  SqliteStatement& query = statement("SELECT id FROM jobs WHERE state IN (2, 3) ORDER BY id");
  for (const std::int64_t id : ids(query)) {
    const Job job = *find(id);
    if (job.state == JobState::kPublishing) {
      recovered.publishing.push_back(job);
      continue;
    }
    const bool is_slurm = keeps_slurm && is_slurm_owner(job.owner);
    // A job that was told to stop is cancelled here, because no process would stop it. The job's task at Slurm is
    // cancelled later as unknown.
    if (is_slurm && slurm_.has_sent(id, job.attempt) && job.stop_asked.empty()) {
      recovered.with_slurm.push_back(job);
      continue;
    }
    // A job that was being sent to Slurm had not begun.
    const AttemptResult lost =
        is_slurm ? AttemptResult{AttemptOutcome::kReturned, -1, "the daemon ended before it sent the job to Slurm"}
                 : AttemptResult{AttemptOutcome::kLost, -1, "the daemon ended while the job ran"};
    close_attempt(job, lost, now);
    requeue_or_die(job, lost, now);
    recovered.lost.push_back(id);
  }
  slurm_.cancel_orphans();
  return recovered;
}

}  // namespace multum
