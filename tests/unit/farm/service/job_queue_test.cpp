// SPDX-License-Identifier: Apache-2.0
// Tests the ledger of jobs without a daemon: the order of jobs, the permission to report on a job, the effects of
// failures, and the state that a killed process leaves.
#include "host/farm/service/ledger/job_queue.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "host/foundation/base/stopwatch.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::TemporaryFolder;
using Ids = std::vector<std::int64_t>;

const JobQueue::IsIntact kIntact = [](const Job&) { return true; };

class JobQueueTest : public ::testing::Test {
 protected:
  std::int64_t submit(const JobSubmission& submission) { return queue_->submit(submission, kIntact, now_).id; }
  static JobSubmission of(int priority, const Ids& needs = {}) {
    JobSubmission submission;
    submission.type = "drill";
    submission.priority = priority;
    submission.needs = needs;
    return submission;
  }
  std::optional<Job> claim(const std::string& owner = "a") { return queue_->claim(limits_, owner, now_); }
  void succeed(const Job& job) {
    EXPECT_TRUE(queue_->ended(job.id, job.owner, job.attempt, {AttemptOutcome::kSucceeded, 0, ""}, now_));
  }
  bool fail(const Job& job, AttemptOutcome outcome = AttemptOutcome::kFailed) {
    return queue_->ended(job.id, job.owner, job.attempt, {outcome, 4, "no luck"}, now_);
  }
  JobState state(std::int64_t id) { return queue_->find(id)->state; }
  void reopen() {
    queue_.reset();
    queue_ = std::make_unique<JobQueue>(settings());
  }
  LedgerSettings settings(const std::string& name = "jobs.sqlite") const {
    LedgerSettings settings;
    settings.path = folder_ / name;
    settings.results = "/data/results";
    return settings;
  }
  bool retry(std::int64_t id) { return !queue_->retry(id, now_).queued.empty(); }
  Ids retry_all() { return queue_->retry_dead("", now_); }

  TemporaryFolder folder_;
  std::unique_ptr<JobQueue> queue_ = std::make_unique<JobQueue>(settings());
  ClaimLimits limits_ = {{{"default", {}}, {"night", {}}}, {}, 0};
  TimeMs now_ = 1000000;
};

TEST_F(JobQueueTest, EveryFieldComesBack) {
  const std::int64_t needed = submit(of(0));
  JobSubmission submission;
  submission.type = "bake";
  submission.parameters = R"({"lobes":4})";
  submission.queue = "night";
  submission.label = "a \"label\"";
  submission.priority = -7;
  submission.needs = {needed};
  submission.attempt_max = 3;
  submission.deadline = now_ + 50;
  submission.memory_bytes = 1 << 30;
  submission.device = "gpu";
  submission.output = "/out/a.exr";
  submission.key = "key";
  submission.inputs = "inputs";
  const std::int64_t id = submit(submission);
  reopen();
  const Job job = *queue_->find(id);
  EXPECT_EQ(job.type, "bake");
  EXPECT_EQ(job.parameters, R"({"lobes":4})");
  EXPECT_EQ(job.queue, "night");
  EXPECT_EQ(job.label, "a \"label\"");
  EXPECT_EQ(job.priority, -7);
  EXPECT_EQ(job.needs, Ids{needed});
  EXPECT_EQ(queue_->list({}).front().needs, Ids{needed});
  EXPECT_EQ(job.needs_left, 1);
  EXPECT_EQ(job.attempt_max, 3);
  EXPECT_EQ(job.deadline, now_ + 50);
  EXPECT_EQ(job.memory_bytes, 1 << 30);
  EXPECT_EQ(job.device, "gpu");
  EXPECT_EQ(job.output, "/out/a.exr");
  EXPECT_EQ(job.key, "key");
  EXPECT_EQ(job.inputs, "inputs");
  EXPECT_EQ(job.state, JobState::kWaiting);
  EXPECT_EQ(job.created, now_);
  EXPECT_EQ(queue_->find(77), std::nullopt);
}

TEST_F(JobQueueTest, ByPriorityThenByAge) {
  const std::int64_t low = submit(of(-1)), first = submit(of(5)), second = submit(of(5));
  EXPECT_EQ(claim()->id, first);
  EXPECT_EQ(claim()->id, second);
  EXPECT_EQ(claim()->id, low);
  EXPECT_EQ(claim(), std::nullopt);
}

TEST_F(JobQueueTest, QueuesGoByTheirPriorityAndStopAtTheirLimits) {
  JobSubmission night = of(0);
  night.queue = "night";
  const std::int64_t a = submit(of(9)), b = submit(night), c = submit(night);
  limits_.queues["night"].priority = 1;
  limits_.queues["night"].jobs_max = 1;
  EXPECT_EQ(claim()->id, b);
  EXPECT_EQ(claim()->id, a);
  EXPECT_EQ(claim(), std::nullopt) << "one at a time";
  reopen();
  EXPECT_EQ(claim(), std::nullopt) << "running jobs are known after a restart";
  succeed(*queue_->find(b));
  limits_.queues["night"].is_paused = true;
  EXPECT_EQ(claim(), std::nullopt);
  limits_.queues.erase("night");
  EXPECT_EQ(claim(), std::nullopt) << "the queue is not configured";
  limits_.queues["night"] = {};
  EXPECT_EQ(claim()->id, c);
}

TEST_F(JobQueueTest, MemoryIsWaitedForAndDevicesArePassedBy) {
  const auto sized = [&](std::int64_t memory, const std::string& device) {
    JobSubmission submission = of(0);
    submission.memory_bytes = memory;
    submission.device = device;
    return submit(submission);
  };
  limits_.memory_max = 10;
  limits_.device_jobs_max["gpu"] = 1;
  const std::int64_t first = sized(6, "gpu"), busy = sized(1, "gpu"), large = sized(5, ""), small = sized(1, "");
  EXPECT_EQ(claim()->id, first);
  EXPECT_EQ(claim(), std::nullopt)
      << "the small job may overtake the job that waits for the device, but not the large job";
  succeed(*queue_->find(first));
  EXPECT_EQ(claim()->id, busy);
  EXPECT_EQ(claim()->id, large);
  EXPECT_EQ(claim()->id, small);
  for (const std::int64_t id : {busy, large, small}) succeed(*queue_->find(id));
  const std::int64_t huge = sized(100, "");
  EXPECT_EQ(claim()->id, huge) << "it runs without other jobs, since it would never fit next to them";
}

TEST_F(JobQueueTest, OnlyTheLeaseHolderIsListenedTo) {
  const std::int64_t id = submit(of(0));
  const Job first = *claim("a");
  EXPECT_FALSE(queue_->ended(id, "b", 1, {}, now_));
  EXPECT_FALSE(queue_->ended(id, "a", 2, {}, now_));
  EXPECT_FALSE(queue_->begin_publishing(id, "b", 1, "1:2"));
  EXPECT_TRUE(fail(first, AttemptOutcome::kLost));
  now_ = *queue_->find(id)->not_before;
  const Job second = *claim("a");
  EXPECT_EQ(second.attempt, 2);
  EXPECT_FALSE(queue_->begin_publishing(id, "a", first.attempt, "1:2")) << "the first attempt reports late";
  EXPECT_FALSE(fail(first));
  EXPECT_TRUE(queue_->begin_publishing(id, "a", 2, "1:2"));
  EXPECT_FALSE(queue_->begin_publishing(id, "a", 2, "1:2")) << "once";
  EXPECT_FALSE(fail(second)) << "too late";
  queue_->published(id, now_);
  EXPECT_EQ(state(id), JobState::kSucceeded);
  EXPECT_EQ(queue_->find(id)->result_identity, "1:2");
  const std::vector<JobAttempt> attempts = queue_->attempts(id);
  ASSERT_EQ(attempts.size(), 2u);
  EXPECT_EQ(attempts[0].outcome, AttemptOutcome::kLost);
  EXPECT_EQ(attempts[0].message, "no luck");
  EXPECT_EQ(attempts[1].outcome, AttemptOutcome::kSucceeded);
}

TEST_F(JobQueueTest, FailuresBackOffAndThenDie) {
  JobSubmission submission = of(0);
  submission.attempt_max = 3;
  const std::int64_t id = submit(submission);
  for (const TimeMs pause : {1000, 2000}) {
    fail(*claim());
    EXPECT_EQ(claim(), std::nullopt);
    EXPECT_EQ(queue_->next_due(), now_ + pause);
    EXPECT_EQ(queue_->find(id)->message, "no luck");
    now_ += pause;
  }
  fail(*claim());
  EXPECT_EQ(state(id), JobState::kDead);
  EXPECT_EQ(queue_->next_due(), std::nullopt);
  EXPECT_TRUE(retry(id));
  EXPECT_EQ(claim()->attempt, 4) << "attempt numbers continue, so that an old worker cannot be mistaken for a new one";
}

TEST_F(JobQueueTest, WhatWasRefusedIsNotTriedAgainAndWhatWasHandedBackDoesNotCount) {
  const std::int64_t refused = submit(of(0));
  fail(*claim(), AttemptOutcome::kRefused);
  EXPECT_EQ(state(refused), JobState::kDead);
  JobSubmission once = of(0);
  once.attempt_max = 1;
  const std::int64_t id = submit(once);
  for (int i = 0; i < 3; ++i) fail(*claim(), AttemptOutcome::kReturned);
  EXPECT_EQ(state(id), JobState::kQueued);
  fail(*claim(), AttemptOutcome::kLost);
  EXPECT_EQ(state(id), JobState::kDead);
}

TEST_F(JobQueueTest, DependentsWaitAndShareTheFate) {
  const std::int64_t a = submit(of(0)), b = submit(of(0));
  const std::int64_t both = submit(of(9, {a, b})), after = submit(of(9, {both}));
  succeed(*claim());
  EXPECT_EQ(state(both), JobState::kWaiting);
  fail(*claim(), AttemptOutcome::kRefused);
  EXPECT_EQ(state(both), JobState::kDead);
  testing::expect_says(queue_->find(both)->message, {"job 2", "dead"});
  testing::expect_says(queue_->find(after)->message, {"job 3", "dead"});
  expect_error(ErrorCode::kUsage, {"job 2", "dead"}, [&] { submit(of(0, {a, b})); });
  expect_error(ErrorCode::kUsage, {"job 99", "exist"}, [&] { submit(of(0, {99})); });
  // Jobs that died because this job failed return together with it, and wait for it.
  EXPECT_TRUE(retry(b));
  EXPECT_EQ(state(both), JobState::kWaiting);
  EXPECT_EQ(state(after), JobState::kWaiting);
  succeed(*claim());
  EXPECT_EQ(claim()->id, both);
  EXPECT_EQ(state(after), JobState::kWaiting);
}

// No job may wait for a job that will never be retried.
TEST_F(JobQueueTest, ARetryReachesTheRoots) {
  const std::int64_t root = submit(of(0)), other = submit(of(0)), middle = submit(of(0, {root})),
                     leaf = submit(of(0, {middle})), both = submit(of(0, {root, other}));
  fail(*claim(), AttemptOutcome::kRefused);
  queue_->cancel(other, "by a test", now_);
  EXPECT_EQ(queue_->retry(leaf, now_).queued, (Ids{leaf, middle, root}));
  EXPECT_EQ(state(root), JobState::kQueued);
  EXPECT_EQ(state(middle), JobState::kWaiting);
  EXPECT_EQ(state(leaf), JobState::kWaiting);
  EXPECT_EQ(state(both), JobState::kDead) << "it needs the cancelled job too";
  EXPECT_EQ(queue_->retry(other, now_).queued, (Ids{other, both}));
  for (int i = 0; i < 5; ++i) succeed(*claim());
  EXPECT_EQ(queue_->counts()["default"][JobState::kSucceeded], 5);
}

TEST_F(JobQueueTest, RetryingAllLeavesNoneStuck) {
  SqliteTransaction transaction(queue_->database());
  const std::int64_t root = submit(of(0));
  for (int i = 0; i < 2000; ++i) submit(of(0, {root}));
  queue_->cancel(root, "by a test", now_);
  EXPECT_EQ(retry_all().size(), 2001u);
  EXPECT_EQ(claim()->id, root);
}

TEST_F(JobQueueTest, ANeedThatWasPurgedIsNotMet) {
  const std::int64_t root = submit(of(0)), middle = submit(of(0, {root})), leaf = submit(of(0, {middle})),
                     alone = submit(of(-1));
  fail(*claim(), AttemptOutcome::kRefused);
  fail(*claim(), AttemptOutcome::kRefused);
  EXPECT_EQ(queue_->purge({root}), Ids{root});
  const RetryResult refused = queue_->retry(leaf, now_);
  EXPECT_TRUE(refused.queued.empty());
  testing::expect_says(refused.refusal, {"job 3", "job 2", "job 1", "purged"});
  EXPECT_FALSE(retry(middle));
  EXPECT_EQ(state(leaf), JobState::kDead);
  EXPECT_EQ(retry_all(), Ids{alone});
  EXPECT_EQ(state(middle), JobState::kDead);
  testing::expect_says(queue_->find(middle)->message, {"job 1", "purged"});
  expect_error(ErrorCode::kUsage, {"job 1", "exist"}, [&] { submit(of(0, {root})); });
}

TEST_F(JobQueueTest, CancelledInAnyState) {
  const std::int64_t running = submit(of(1)), queued = submit(of(0)), waiting = submit(of(0, {queued}));
  const Job job = *claim();
  EXPECT_EQ(queue_->cancel(running, "by a test", now_), CancelResult::kStopWorker);
  EXPECT_EQ(queue_->cancel(queued, "by a test", now_), CancelResult::kCancelled);
  EXPECT_EQ(state(waiting), JobState::kDead);
  EXPECT_EQ(queue_->cancel(queued, "by a test", now_), CancelResult::kTooLate);
  EXPECT_EQ(queue_->cancel(55, "by a test", now_), CancelResult::kUnknown);
  EXPECT_TRUE(fail(job, AttemptOutcome::kCancelled));
  EXPECT_EQ(state(running), JobState::kCancelled);
  EXPECT_EQ(claim(), std::nullopt);
  EXPECT_TRUE(retry(running));
  const Job again = *claim();
  queue_->begin_publishing(again.id, "a", again.attempt, "");
  EXPECT_EQ(queue_->cancel(running, "by a test", now_), CancelResult::kTooLate);
}

// If the cancel request arrives between the end of an attempt and its report, or before the daemon is killed, the job
// does not run again.
TEST_F(JobQueueTest, ACancelOutlivesTheAttemptThatItWasMeantFor) {
  const std::int64_t id = submit(of(0)), dependent = submit(of(0, {id}));
  const Job failing = *claim();
  EXPECT_EQ(queue_->cancel(id, "by a test", now_), CancelResult::kStopWorker);
  EXPECT_TRUE(fail(failing, AttemptOutcome::kFailed));
  EXPECT_EQ(state(id), JobState::kCancelled);
  EXPECT_EQ(state(dependent), JobState::kDead);
  EXPECT_TRUE(retry(id));
  EXPECT_TRUE(fail(*claim(), AttemptOutcome::kFailed));
  EXPECT_EQ(state(id), JobState::kQueued) << "nobody has cancelled this attempt";
  now_ += 1000000;
  claim();
  EXPECT_EQ(queue_->cancel(id, "by a test", now_), CancelResult::kStopWorker);
  reopen();
  queue_->recover(now_);
  EXPECT_EQ(state(id), JobState::kCancelled);
}

TEST_F(JobQueueTest, DeadlinesPass) {
  JobSubmission submission = of(0);
  submission.deadline = now_ + 10;
  const std::int64_t running = submit(submission);
  const Job job = *claim();
  submission.needs = {running};
  const std::int64_t waiting = submit(submission);
  EXPECT_EQ(queue_->next_due(), now_ + 10);
  EXPECT_TRUE(queue_->expire_deadlines(now_ + 9).dead.empty());
  now_ += 10;
  const JobQueue::Overdue overdue = queue_->expire_deadlines(now_);
  EXPECT_EQ(overdue.dead, Ids{waiting});
  EXPECT_EQ(overdue.running, Ids{running});
  fail(job, AttemptOutcome::kCancelled);
  EXPECT_TRUE(retry(running));
  EXPECT_EQ(queue_->find(running)->deadline, std::nullopt) << "submitting the job again removes its deadline";
}

TEST_F(JobQueueTest, TheSameKeyAndOutputIsTheSameJob) {
  JobSubmission submission = of(0);
  submission.key = "k";
  submission.output = "/a";
  const std::int64_t id = submit(submission);
  EXPECT_FALSE(queue_->submit(submission, kIntact, now_).is_new);
  succeed(*claim());
  EXPECT_EQ(submit(submission), id);
  EXPECT_EQ(queue_->succeeded_with_key("k").size(), 1u);
  const SubmitResult gone = queue_->submit(
      submission, [](const Job&) { return false; }, now_);
  EXPECT_TRUE(gone.is_new) << "its result was deleted or changed";
  submission.output = "/b";
  EXPECT_NE(submit(submission), id);
  EXPECT_TRUE(queue_->succeeded_with_key("").empty());
  submission.key = "";
  EXPECT_NE(submit(submission), submit(submission));
}

TEST_F(JobQueueTest, AResultOfOtherInputsIsNotTakenForItsKey) {
  JobSubmission submission = of(0);
  submission.key = "k";
  submission.output = "/a";
  const std::int64_t id = submit(submission);
  queue_->begin_publishing(id, "a", claim()->attempt, "7:8");
  queue_->forget_key(id);
  queue_->published(id, now_);
  EXPECT_TRUE(queue_->succeeded_with_key("k").empty());
  EXPECT_NE(submit(submission), id);
}

// A machine's clock may be set back by any amount, by hand or by its radio clock.
TEST_F(JobQueueTest, AClockThatIsSetBackMakesNobodyWait) {
  submit(of(0));
  fail(*claim());
  const std::int64_t running = submit(of(1));
  const Job job = *claim();
  EXPECT_EQ(job.id, running);
  now_ -= 900000;
  queue_->forgive_back_offs(now_);
  EXPECT_EQ(claim("b")->attempt, 2) << "its back-off would otherwise last fifteen more minutes";
  succeed(job);
  EXPECT_LT(*queue_->find(running)->finished, *queue_->find(running)->started);
  EXPECT_TRUE(queue_->purge_finished_before(now_, 10).empty());
  EXPECT_EQ(queue_->purge_finished_before(now_ + 1, 10), Ids{running});
  const std::int64_t later = submit(of(0));
  EXPECT_EQ(claim()->id, later);
}

TEST_F(JobQueueTest, AChainOfThousandsDiesAndIsTriedAgainAtOnce) {
  SqliteTransaction transaction(queue_->database());  // otherwise each job would have to wait for the disk
  Ids chain = {submit(of(0))};
  for (int i = 0; i < 20000; ++i) chain.push_back(submit(of(0, {chain.back()})));
  fail(*claim(), AttemptOutcome::kRefused);
  EXPECT_EQ(queue_->counts()["default"][JobState::kDead], 20001);
  EXPECT_TRUE(retry(chain.front()));
  EXPECT_EQ(queue_->counts()["default"][JobState::kWaiting], 20000);
  EXPECT_EQ(claim()->id, chain.front());
}

TEST_F(JobQueueTest, ListsAreOfTheirFilter) {
  for (int i = 0; i < 60; ++i) {
    JobSubmission submission = of(i % 7);
    submission.queue = i % 3 == 0 ? "night" : "default";
    submit(submission);
  }
  for (int i = 0; i < 12; ++i) fail(*claim(), i % 2 == 0 ? AttemptOutcome::kRefused : AttemptOutcome::kFailed);
  succeed(*claim());
  claim();
  const std::vector<Job> all = queue_->list({std::nullopt, "", std::nullopt, 1000});
  for (const auto state : {std::optional<JobState>(), std::optional(JobState::kQueued), std::optional(JobState::kDead),
                           std::optional(JobState::kRunning), std::optional(JobState::kSucceeded)})
    for (const std::string queue : {"", "default", "night", "none"})
      for (const auto before : {std::optional<std::int64_t>(), std::optional<std::int64_t>(31)})
        for (const int limit : {1, 4, 1000}) {
          Ids expected, found;
          for (const Job& job : all)
            if ((!state || job.state == *state) && (queue.empty() || job.queue == queue) &&
                (!before || job.id < *before) && static_cast<int>(expected.size()) < limit)
              expected.push_back(job.id);
          for (const Job& job : queue_->list({state, queue, before, limit})) found.push_back(job.id);
          EXPECT_EQ(found, expected) << queue << " " << limit;
        }
}

// A page asks for the dead jobs every second.
TEST_F(JobQueueTest, AListOfFewJobsDoesNotReadTheOthers) {
  SqliteTransaction transaction(queue_->database());  // otherwise each job would have to wait for the disk
  for (int i = 0; i < 5000; ++i) submit(of(i == 0 ? 1 : 0));
  fail(*claim(), AttemptOutcome::kRefused);
  const auto seconds = [&](const JobFilter& filter, std::size_t expected) {
    double least = 1e9;
    for (int i = 0; i < 20; ++i) {
      const Stopwatch stopwatch;
      EXPECT_EQ(queue_->list(filter).size(), expected);
      least = std::min(least, stopwatch.seconds());
    }
    return least;
  };
  const double newest = seconds({std::nullopt, "", std::nullopt, 50}, 50);
  EXPECT_LT(seconds({JobState::kDead, "", std::nullopt, 50}, 1), 3.0 * newest);
  EXPECT_LT(seconds({JobState::kDead, "default", std::nullopt, 50}, 1), 3.0 * newest);
}

// Changes a ledger to the state in which version 3 would leave it.
const char* const kBackToVersion3 =
    "DROP TABLE slurm_parts; DROP TABLE meta; DROP TABLE left_overs; DROP TABLE uploads; ALTER TABLE needs RENAME TO "
    "n; DROP INDEX needs_of; "
    "CREATE TABLE needs (job INTEGER NOT NULL REFERENCES jobs (id) ON DELETE CASCADE, needs INTEGER NOT NULL "
    "REFERENCES "
    "jobs (id) ON DELETE CASCADE, PRIMARY KEY (job, needs)) WITHOUT ROWID; CREATE INDEX needs_of ON needs (needs); "
    "INSERT INTO needs SELECT * FROM n; DROP TABLE n; PRAGMA application_id = 0; PRAGMA user_version = 3;";

TEST_F(JobQueueTest, AnEarlierLedgerIsTakenOver) {
  JobSubmission submission = of(3);
  submission.key = "k";
  const std::int64_t id = submit(submission), after = submit(of(9, {id}));
  queue_->database().execute(kBackToVersion3);
  queue_->database().execute(
      "ALTER TABLE jobs DROP COLUMN inputs; ALTER TABLE jobs DROP COLUMN stop_asked; PRAGMA user_version = 1;");
  reopen();
  EXPECT_EQ(queue_->find(id)->priority, 3);
  EXPECT_EQ(queue_->find(id)->key, "") << "nothing proves that its inputs are unchanged";
  EXPECT_EQ(queue_->find(after)->needs, Ids{id});
  const Job job = *claim();
  EXPECT_EQ(job.id, id);
  succeed(job);
  EXPECT_EQ(state(after), JobState::kQueued);
}

// The next start of the daemon adds the column.
TEST_F(JobQueueTest, ALedgerFromBeforeAFieldGetsIt) {
  const std::int64_t id = submit(of(3));
  queue_->database().execute("ALTER TABLE jobs DROP COLUMN stop_asked; ALTER TABLE jobs DROP COLUMN reused_from;");
  reopen();
  const Job job = *claim();
  EXPECT_EQ(job.id, id);
  EXPECT_EQ(job.stop_asked, "");
  EXPECT_FALSE(job.reused_from);
  EXPECT_EQ(queue_->cancel(id, "enough", now_), CancelResult::kStopWorker);
  EXPECT_EQ(queue_->find(id)->stop_asked, "enough");
}

// Version 3 could leave a job that waits for a dead one.
TEST_F(JobQueueTest, WhoWaitsForeverInAnEarlierLedgerDies) {
  const std::int64_t dead = submit(of(0)), waiting = submit(of(0, {dead})), last = submit(of(0, {waiting})),
                     met = submit(of(0)), ready = submit(of(0, {met}));
  fail(*claim(), AttemptOutcome::kRefused);
  succeed(*claim());
  queue_->database().execute(kBackToVersion3);
  queue_->database().execute("UPDATE jobs SET state = 0, needs_left = 1, finished = NULL WHERE id IN (2, 3, 5)");
  reopen();
  queue_->recover(now_);
  EXPECT_EQ(state(waiting), JobState::kDead);
  EXPECT_EQ(state(last), JobState::kDead);
  EXPECT_EQ(state(ready), JobState::kQueued);
  testing::expect_says(queue_->find(waiting)->message, {"job 1", "dead"});
}

TEST_F(JobQueueTest, ADeadProcessLeavesNothingRunning) {
  const std::int64_t lost = submit(of(2)), publishing = submit(of(1));
  claim();
  queue_->begin_publishing(publishing, "a", claim()->attempt, "7:8");
  reopen();
  const JobQueue::Recovered recovered = queue_->recover(now_);
  EXPECT_EQ(recovered.lost, Ids{lost});
  EXPECT_EQ(state(lost), JobState::kQueued);
  EXPECT_EQ(queue_->attempts(lost)[0].outcome, AttemptOutcome::kLost);
  ASSERT_EQ(recovered.publishing.size(), 1u);
  EXPECT_EQ(recovered.publishing[0].id, publishing);
  EXPECT_EQ(recovered.publishing[0].result_identity, "7:8");
  queue_->published(publishing, now_);
  EXPECT_EQ(queue_->counts()["default"][JobState::kSucceeded], 1);
}

TEST_F(JobQueueTest, PurgesOnlyWhatNothingNeeds) {
  const std::int64_t a = submit(of(0)), b = submit(of(0, {a})), c = submit(of(-1));
  succeed(*claim());
  EXPECT_EQ(queue_->purge({a, b, c, 99}), Ids{}) << "b needs a, and the other jobs are not finished";
  succeed(*claim());
  EXPECT_EQ(queue_->purge_finished_before(now_, 10), Ids{}) << "not before";
  EXPECT_EQ(queue_->purge_finished_before(now_ + 1, 1), Ids{a});
  EXPECT_EQ(queue_->find(b)->needs, Ids{a}) << "b still lists the job that it needed";
  EXPECT_GT(submit(of(0)), c) << "numbers of purged jobs are not reused";
}

TEST_F(JobQueueTest, PurgedJobsAreNotedWithWhatTheyLeave) {
  JobSubmission submission = of(0);
  submission.output = "/data/results/sub/a.exr";
  const std::int64_t inside = submit(submission);
  queue_->begin_publishing(inside, "a", claim()->attempt, "7:8");
  queue_->published(inside, now_);
  submission.output = "/data/results.exr";
  const std::int64_t outside = submit(submission);
  succeed(*claim());
  EXPECT_TRUE(queue_->files().left_overs(0, 10).empty());
  {
    SqliteTransaction undone(queue_->database());
    queue_->purge({inside});
  }
  EXPECT_TRUE(queue_->files().left_overs(0, 10).empty()) << "the purge was not committed";
  queue_->purge({inside, outside});
  reopen();
  const std::vector<FileNotes::LeftOver> noted = queue_->files().left_overs(0, 10);
  ASSERT_EQ(noted.size(), 2u);
  EXPECT_EQ(noted[0].output, "/data/results/sub/a.exr");
  EXPECT_EQ(noted[0].identity, "7:8");
  EXPECT_EQ(noted[1].output, "") << "results outside the data folder are never removed";
  EXPECT_EQ(queue_->files().left_overs(inside, 10).size(), 1u);
  queue_->files().forget_left_over(inside);
  EXPECT_EQ(queue_->files().left_overs(0, 10).size(), 1u);
  EXPECT_TRUE(queue_->was_purged(inside));
  EXPECT_FALSE(queue_->was_purged(77)) << "this job never existed";
}

// The oldest job must stay. This does not prevent the purge of other jobs.
TEST_F(JobQueueTest, WhatIsNeededStillKeepsNothingElseFromBeingPurged) {
  const std::int64_t needed = submit(of(0)), needing = submit(of(-1, {needed}));
  succeed(*claim());
  now_ += 10;
  const std::int64_t free = submit(of(0));
  succeed(*claim());
  EXPECT_EQ(queue_->purge_finished_before(now_ + 1, 1), Ids{free});
  EXPECT_EQ(state(needing), JobState::kQueued);
}

TEST_F(JobQueueTest, NumbersGoOnAboveWhatOthersHaveUsed) {
  const std::int64_t first = submit(of(0));
  queue_->number_above(500);
  EXPECT_EQ(submit(of(0)), 501);
  queue_->number_above(17);
  EXPECT_EQ(submit(of(0)), 502);
  succeed(*claim());
  const JobQueue::Numbers numbers = queue_->numbers();
  EXPECT_TRUE(numbers.is_finished_with(first));
  EXPECT_FALSE(numbers.is_finished_with(300)) << "of another ledger";
  EXPECT_FALSE(numbers.is_finished_with(501)) << "it waits";
  EXPECT_FALSE(numbers.is_finished_with(503));
  EXPECT_FALSE(queue_->was_purged(300));
}

// The job is submitted again while its worker is being stopped, when the running job is about to be cancelled.
TEST_F(JobQueueTest, AJobThatIsBeingCancelledIsNotTakenForANewOne) {
  JobSubmission submission = of(0);
  submission.key = "k";
  const std::int64_t id = submit(submission);
  claim();
  EXPECT_EQ(submit(submission), id);
  queue_->cancel(id, "by a test", now_);
  EXPECT_NE(submit(submission), id);
}

TEST_F(JobQueueTest, SmallJobsOfOtherQueuesDoNotStarveALargeOne) {
  const auto sized = [&](std::int64_t memory, const std::string& queue) {
    JobSubmission submission = of(0);
    submission.memory_bytes = memory;
    submission.queue = queue;
    return submit(submission);
  };
  limits_.memory_max = 10;
  const std::int64_t running = sized(4, "default"), large = sized(8, "night"), small = sized(4, "default");
  EXPECT_EQ(claim()->id, running);
  EXPECT_EQ(claim(), std::nullopt) << "the large job comes first, and the small one waits for it";
  succeed(*queue_->find(running));
  EXPECT_EQ(claim()->id, large);
  succeed(*queue_->find(large));
  EXPECT_EQ(claim()->id, small);
}

TEST_F(JobQueueTest, KnowsTheFolderThatItBelongsTo) {
  EXPECT_EQ(queue_->instance(), "");
  LedgerSettings owned = settings();
  owned.instance = "0000aaaa";
  queue_.reset();
  EXPECT_EQ(JobQueue(owned).instance(), "0000aaaa");
  owned.may_begin = false;
  EXPECT_EQ(JobQueue(owned).instance(), "0000aaaa");
  owned.instance = "0000bbbb";
  expect_error(ErrorCode::kEnvironment, {owned.path, "0000aaaa", "0000bbbb", "--new-ledger"}, [&] { JobQueue{owned}; });
  owned.may_begin = true;
  EXPECT_EQ(JobQueue(owned).instance(), "0000aaaa") << "the folder had no instance name yet";
  LedgerSettings empty = settings("empty.sqlite");
  empty.may_begin = false;
  expect_error(ErrorCode::kEnvironment, {empty.path, "empty"}, [&] { JobQueue{empty}; });
  {
    SqliteDatabase other(folder_ / "other.sqlite");
    other.execute("CREATE TABLE jobs (id)");
  }
  expect_error(ErrorCode::kInput, {folder_ / "other.sqlite", "not a ledger"},
               [&] { JobQueue{settings("other.sqlite")}; });
}

// Runs random commands. After each command, the invariants must hold, and the state in memory must equal the database.
TEST_F(JobQueueTest, RandomLivesKeepTheBooks) {
  const unsigned seed = 20261122;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const auto pick = [&](int count) { return static_cast<int>(random() % static_cast<unsigned>(count)); };
  limits_.queues["default"].jobs_max = 4;
  std::vector<Job> leases;
  std::map<std::int64_t, int> successes;
  for (int step = 0; step < 3000; ++step) {
    const std::int64_t any = 1 + pick(std::max(1, step / 4));
    now_ += pick(400);
    switch (pick(8)) {
      case 0:
      case 1: {
        JobSubmission submission = of(pick(3));
        submission.attempt_max = 1 + pick(3);
        if (pick(3) == 0)
          if (const std::optional<Job> needed = queue_->find(any); needed && !is_final(needed->state))
            submission.needs = {any};
        submit(submission);
        break;
      }
      case 2:
      case 3:
        if (const std::optional<Job> job = claim("owner " + std::to_string(step))) leases.push_back(*job);
        break;
      case 4:
      case 5:
        if (!leases.empty()) {
          const std::size_t at = random() % leases.size();
          const Job job = leases[at];
          // Otherwise the job would end twice.
          if (pick(4) != 0) leases.erase(leases.begin() + static_cast<std::ptrdiff_t>(at));
          const AttemptResult result = {static_cast<AttemptOutcome>(1 + pick(6)), pick(5), ""};
          const bool is_taken = queue_->ended(job.id, job.owner, job.attempt, result, now_);
          if (is_taken && result.outcome == AttemptOutcome::kSucceeded) {
            EXPECT_EQ(++successes[job.id], 1) << job.id;
          }
        }
        break;
      case 6: queue_->cancel(any, "", now_); break;
      default:
        if (pick(20) == 0) {
          reopen();
          queue_->recover(now_);
        } else if (pick(4) == 0) {
          queue_->retry(any, now_);
        }
    }
    const auto counts = queue_->counts()["default"];
    ASSERT_LE(counts.contains(JobState::kRunning) ? counts.at(JobState::kRunning) : 0, 4);
    if (step % 100 == 0)
      for (const Job& job : queue_->list({std::nullopt, "", std::nullopt, 1000})) {
        const Job whole = *queue_->find(job.id);
        int left = 0;
        for (const std::int64_t needed : whole.needs) left += state(needed) != JobState::kSucceeded ? 1 : 0;
        if (whole.state <= JobState::kRunning) {
          ASSERT_EQ(whole.needs_left, left) << job.id;
        }
        if (whole.state == JobState::kWaiting) {
          ASSERT_GT(left, 0) << job.id;
        }
      }
  }
  EXPECT_GT(successes.size(), 50u);
  EXPECT_EQ(queue_->database().damage(), "");
}

TEST_F(JobQueueTest, ASecondProcessOrADamagedFileIsRefused) {
  expect_error(ErrorCode::kEnvironment, {folder_ / "jobs.sqlite", "another process"}, [&] { JobQueue{settings()}; });
  for (int i = 0; i < 200; ++i) submit(of(0));
  queue_.reset();
  testing::write_bytes(folder_ / "text.sqlite", std::string(5000, 'x'));
  expect_error(ErrorCode::kInput, {folder_ / "text.sqlite", "damaged"}, [&] { JobQueue{settings("text.sqlite")}; });
  std::string bytes = testing::read_bytes(folder_ / "jobs.sqlite");
  for (std::size_t page = 2; page < bytes.size() / 4096; ++page) bytes.replace(page * 4096 + 100, 400, 400, '\xee');
  testing::write_bytes(folder_ / "jobs.sqlite", bytes);
  expect_error(ErrorCode::kInput, {folder_ / "jobs.sqlite", "damaged"}, [&] { JobQueue{settings()}; });
  expect_error(ErrorCode::kEnvironment, {folder_ / "none/jobs.sqlite"},
               [&] { JobQueue{settings("none/jobs.sqlite")}; });
}

}  // namespace
}  // namespace multum
