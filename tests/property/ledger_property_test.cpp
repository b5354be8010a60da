// SPDX-License-Identifier: Apache-2.0
// Compares random histories of a ledger with a model of it (ledger_model.h). After every step, both must agree on every
// job. No job may wait for a job that has failed or is gone, and no job number is used twice. At the end, every job
// that may run is run, and every job has ended. The seed is fixed. RC_PARAMS="seed=N max_success=20000" sets another
// seed, and a failure prints its seed.
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <memory>

#include "host/farm/service/ledger/job_queue.h"
#include "host/foundation/base/error.h"
#include "tests/property/ledger_model.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::LedgerModel;
using testing::TemporaryFolder;
using Ids = std::vector<std::int64_t>;

// This must be set before the first property runs, because RapidCheck reads it at that time.
const int g_seeded = setenv("RC_PARAMS", "seed=20261123 max_success=400", 0);

constexpr RetryPolicy kPolicy = {100, 1000};
constexpr char kResults[] = "/data/results";

// Holds the next action, and four numbers that choose the jobs. The numbers are taken modulo the number of jobs, so
// that shortened sequences stay valid.
struct Step {
  int kind, a, b, c, d;
};

std::ostream& operator<<(std::ostream& out, const Step& step) {
  return out << step.kind << ":" << step.a << "," << step.b << "," << step.c << "," << step.d;
}

rc::Gen<Step> steps() {
  const auto number = rc::gen::inRange(0, 1000);
  return rc::gen::map(rc::gen::tuple(rc::gen::inRange(0, 100), number, number, number, number), [](const auto& t) {
    return Step{std::get<0>(t), std::get<1>(t), std::get<2>(t), std::get<3>(t), std::get<4>(t)};
  });
}

// An empty ledger is made only once and then copied, because making a ledger waits for the disk.
const std::string& empty_ledger() {
  static const std::string bytes = [] {
    const TemporaryFolder folder;
    LedgerSettings settings;
    settings.path = folder / "jobs.sqlite";
    { const JobQueue made(settings); }
    return testing::read_bytes(settings.path);
  }();
  return bytes;
}

class Pair {
 public:
  Pair() : model_(kPolicy) {
    limits_.queues = {{"default", {}}, {"night", {}}};
    limits_.queues["default"].jobs_max = 3;
    limits_.queues["night"].memory_max = 6;
    limits_.queues["night"].priority = 1;
    limits_.device_jobs_max["gpu"] = 1;
    limits_.memory_max = 12;
    testing::write_bytes(folder_ / "jobs.sqlite", empty_ledger());
    open();
  }

  void run(const Step& step) {
    // Some steps are rolled back, as on a full disk.
    const bool is_undone = step.kind < 90 && step.d % 10 == 0;
    if (!is_undone) {
      act(step);
    } else {
      const LedgerModel before = model_;
      const std::vector<Job> leases = leases_;
      {
        SqliteTransaction transaction(queue_->database());
        act(step);
      }
      queue_->resync();
      model_ = before;
      leases_ = leases;
    }
    check();
  }

  // Runs every job that may run. After that, no job may be left.
  void run_to_the_end() {
    ClaimLimits limits;
    limits.queues = {{"default", {}}, {"night", {}}};
    for (const auto& [id, job] : std::map(model_.jobs())) {
      if (job.state == JobState::kPublishing) publish(id, true);
      if (job.state == JobState::kRunning) end(id, job.owner, job.attempt, AttemptOutcome::kFailed);
    }
    for (int turn = 0;; ++turn) {
      RC_ASSERT(turn < 2000);
      now_ += 2000;
      queue_->forgive_back_offs(now_);
      model_.forgive_back_offs(now_);
      model_.expire(now_);
      queue_->expire_deadlines(now_);
      const std::optional<Job> job = claim(limits);
      if (!job && !queue_->next_due()) break;
      if (!job) continue;
      end(job->id, job->owner, job->attempt, static_cast<AttemptOutcome>(1 + turn % 3));
      check();
    }
    for (const Job& job : all()) RC_ASSERT(is_final(job.state));
    RC_ASSERT(!queue_->next_due());
    RC_ASSERT(queue_->database().damage().empty());
  }

 private:
  void open() {
    LedgerSettings settings;
    settings.path = folder_ / "jobs.sqlite";
    settings.results = kResults;
    settings.retry = kPolicy;
    queue_ = std::make_unique<JobQueue>(settings);
    queue_->database().execute("PRAGMA synchronous = OFF");  // power cuts are not tested here
  }

  // Returns the number of a job that exists, existed, or never existed.
  std::int64_t any(int number) const { return 1 + number % (model_.highest() + 2); }

  void act(const Step& s) {
    if (s.kind < 25) submit(s);
    else if (s.kind < 42) claim(limits_);
    else if (s.kind < 58) end_any(s);
    else if (s.kind < 66) cancel(any(s.a));
    else if (s.kind < 76) retry(any(s.a));
    else if (s.kind < 79) retry_all(s.a % 2 == 0 ? "" : "night");
    else if (s.kind < 84) purge({any(s.a), any(s.b), any(s.c)});
    else if (s.kind < 86) purge_before(s);
    else if (s.kind < 90) wait(s);
    else if (s.kind < 94) now_ += s.a * (s.b % 3 == 0 ? 100 : 1);
    else if (s.kind < 96) now_ -= s.a * (s.b % 3 == 0 ? 100 : 1);
    else restart();
  }

  void submit(const Step& s) {
    JobSubmission submission;
    submission.type = "drill";
    submission.queue = s.a % 3 == 0 ? "night" : "default";
    submission.priority = s.a % 5 - 2;
    submission.attempt_max = 1 + s.b % 3;
    submission.memory_bytes = s.b % 8;
    if (s.b % 4 == 0) submission.device = "gpu";
    if (s.c % 3 != 0)
      submission.output = (s.c % 2 == 0 ? std::string(kResults) : "/out") + "/" + std::to_string(s.c % 5);
    if (s.c % 4 == 0) {  // comes from a small set, so that keys repeat
      submission.key = s.c % 8 == 0 ? "a" : "b";
      submission.output = std::string(kResults) + "/" + submission.key;
    }
    if (s.d % 5 == 0) submission.deadline = now_ + s.b - 50;
    for (int i = 0; i < s.d % 4; ++i) submission.needs.push_back(any(s.c * (i + 1) + s.a));
    const std::optional<SubmitResult> expected = model_.submit(submission);
    try {
      const SubmitResult result = queue_->submit(
          submission, [](const Job&) { return true; }, now_);
      RC_ASSERT(expected);
      RC_ASSERT(result.is_new == expected->is_new);
      RC_ASSERT(result.id == expected->id);  // no job number is used twice
    } catch (const Error&) {
      RC_ASSERT(!expected);
    }
  }

  std::optional<Job> claim(const ClaimLimits& limits) {
    const std::string owner = "worker " + std::to_string(++claims_);
    const std::optional<Job> job = queue_->claim(limits, owner, now_);
    const std::optional<std::int64_t> expected = model_.claim(limits, owner, now_);
    RC_ASSERT(job.has_value() == expected.has_value());
    if (job) {
      RC_ASSERT(job->id == *expected);
      leases_.push_back(*job);
    }
    return job;
  }

  // Ends a job on behalf of a worker that has, had or never had the job.
  void end_any(const Step& s) {
    if (leases_.empty()) return;
    const Job job = leases_[static_cast<std::size_t>(s.a) % leases_.size()];
    const std::string owner = s.b % 10 == 0 ? "nobody" : job.owner;
    if (s.c % 3 == 0) {
      const bool is_mine = model_.begin_publishing(job.id, owner, job.attempt);
      RC_ASSERT(queue_->begin_publishing(job.id, owner, job.attempt, "1:2") == is_mine);
      if (is_mine && s.b % 3 != 0) publish(job.id, s.b % 4 != 0);  // otherwise the daemon dies first
    } else {
      constexpr AttemptOutcome kOutcomes[] = {AttemptOutcome::kSucceeded, AttemptOutcome::kFailed,
                                              AttemptOutcome::kRefused,   AttemptOutcome::kLost,
                                              AttemptOutcome::kCancelled, AttemptOutcome::kReturned};
      end(job.id, owner, job.attempt, kOutcomes[s.d % 6]);
    }
  }

  void end(std::int64_t id, const std::string& owner, int attempt, AttemptOutcome outcome) {
    const bool is_taken = queue_->ended(id, owner, attempt, {outcome, 4, "no luck"}, now_);
    RC_ASSERT(is_taken == model_.ended(id, owner, attempt, outcome, now_));
  }

  void publish(std::int64_t id, bool is_in_place) {
    if (is_in_place) {
      queue_->published(id, now_);
      model_.published(id, now_);
    } else {
      queue_->publishing_failed(id, {AttemptOutcome::kFailed, 4, "no room"}, now_);
      model_.publishing_failed(id, now_);
    }
  }

  void cancel(std::int64_t id) {
    RC_ASSERT(queue_->cancel(id, "by a test", now_) == model_.cancel(id, "by a test", now_));
  }

  void retry(std::int64_t id) {
    const RetryResult result = queue_->retry(id, now_);
    RC_ASSERT(std::set(result.queued.begin(), result.queued.end()) == model_.retry(id, now_));
    RC_ASSERT(result.queued.empty() != result.refusal.empty());
  }

  void retry_all(const std::string& queue) {
    const Ids retried = queue_->retry_dead(queue, now_);
    RC_ASSERT(std::set(retried.begin(), retried.end()) == model_.retry_dead(queue, now_));
  }

  void purge(const Ids& ids) { RC_ASSERT(queue_->purge(ids) == model_.purge(ids, kResults)); }

  void purge_before(const Step& s) {
    const TimeMs before = now_ - s.a % 300;
    const int limit = 1 + s.b % 3;
    const Ids purged = queue_->purge_finished_before(before, limit);
    for (const std::int64_t id : purged) RC_ASSERT(model_.jobs().at(id).finished < before);
    RC_ASSERT(model_.purge(purged, kResults) == purged);
    if (static_cast<int>(purged.size()) == limit) return;
    Ids older;
    for (const auto& [id, job] : model_.jobs())
      if (job.finished.value_or(before) < before) older.push_back(id);
    RC_ASSERT(LedgerModel(model_).purge(older, kResults).empty());  // every job that could be removed was removed
  }

  void wait(const Step& s) {
    const std::optional<TimeMs> due = queue_->next_due();
    if (due && s.a % 3 != 0) now_ = std::max(now_, *due);
    if (s.b % 2 == 0) {
      queue_->forgive_back_offs(now_);
      model_.forgive_back_offs(now_);
    }
    queue_->expire_deadlines(now_);
    model_.expire(now_);
  }

  // The workers and the daemon die. A result that was being published may or may not be in place afterwards.
  void restart() {
    open_again();
    const JobQueue::Recovered recovered = queue_->recover(now_);
    model_.restart(now_);
    bool is_in_place = true;
    for (const Job& job : recovered.publishing) {
      RC_ASSERT(job.result_identity == "1:2");
      publish(job.id, is_in_place = !is_in_place);
    }
  }

  void open_again() {
    queue_.reset();
    open();
  }

  std::vector<Job> all() {
    std::vector<Job> jobs = queue_->list({std::nullopt, "", std::nullopt, 1000});
    RC_ASSERT(jobs.size() == model_.jobs().size());  // no job may be lost
    return jobs;
  }

  void check() {
    std::map<std::string, std::map<JobState, std::int64_t>> counts;
    for (const Job& job : all()) {
      RC_ASSERT(model_.knows(job.id));
      const LedgerModel::ModelJob& expected = model_.jobs().at(job.id);
      RC_ASSERT(job.state == expected.state);
      RC_ASSERT(job.attempt == expected.attempt);
      RC_ASSERT(job.owner == expected.owner);
      RC_ASSERT(job.needs == expected.needs);
      RC_ASSERT(job.not_before == expected.not_before);
      RC_ASSERT(job.deadline == expected.deadline);
      RC_ASSERT(job.finished.has_value() == is_final(job.state));
      RC_ASSERT(expected.successes == (job.state == JobState::kSucceeded ? 1 : 0));
      ++counts[job.queue][job.state];
      if (job.state != JobState::kWaiting) continue;
      RC_ASSERT(job.needs_left == model_.needs_left(job.id));
      RC_ASSERT(job.needs_left > 0);
      for (const std::int64_t need : job.needs) {
        const std::optional<Job> needed = queue_->find(need);
        RC_ASSERT(needed && (!is_final(needed->state) || needed->state == JobState::kSucceeded));
      }
    }
    RC_ASSERT(queue_->counts() == counts);
    RC_ASSERT(queue_->next_due() == model_.next_due());
    std::map<std::int64_t, std::string> left;
    for (const FileNotes::LeftOver& one : queue_->files().left_overs(0, 1000)) left[one.job] = one.output;
    RC_ASSERT(left == model_.left_overs());
    for (const auto& [queue, limits] : limits_.queues)
      RC_ASSERT(counts[queue][JobState::kRunning] + counts[queue][JobState::kPublishing] <= limits.jobs_max);
  }

  TemporaryFolder folder_;
  LedgerModel model_;
  std::unique_ptr<JobQueue> queue_;
  ClaimLimits limits_;
  std::vector<Job> leases_;
  int claims_ = 0;
  TimeMs now_ = 1000000000;
};

RC_GTEST_PROP(LedgerProperty, IsAsItsModelAndLeavesNobodyWaiting, ()) {
  const auto life = *rc::gen::scale(3.0, rc::gen::container<std::vector<Step>>(steps()));
  Pair pair;
  for (const Step& step : life) pair.run(step);
  pair.run_to_the_end();
  RC_CLASSIFY(life.size() > 100, "over 100 steps");
}

}  // namespace
}  // namespace multum
