// SPDX-License-Identifier: Apache-2.0
// Tests the batches that are sent to Slurm, the parsing of Slurm's lists, and what the ledger stores about both.
// tests/service/slurm_test.py runs a real Slurm.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "host/farm/service/ledger/job_queue.h"
#include "host/farm/service/slurm/slurm_commands.h"
#include "host/farm/service/slurm/slurm_folder.h"
#include "host/farm/service/slurm/slurm_plan.h"
#include "host/foundation/base/error.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using Chunks = std::vector<std::vector<std::size_t>>;

TEST(SlurmChunks, SmallJobsShareTasksAndOthersHaveTheirOwn) {
  EXPECT_EQ(make_chunks({}, 30.0), Chunks{});
  EXPECT_EQ(make_chunks({10.0, 10.0, 10.0, 10.0}, 30.0), (Chunks{{0, 1, 2}, {3}}));
  // Neither a job of unknown duration nor a long job ends the open chunk.
  EXPECT_EQ(make_chunks({10.0, -1.0, 40.0, 10.0}, 30.0), (Chunks{{0, 3}, {1}, {2}}));
  EXPECT_EQ(make_chunks({0.0, 0.0}, 0.0), (Chunks{{0}, {1}}));
  const Chunks many = make_chunks(std::vector<double>(kChunkJobsMax + 1, 0.0), 30.0);
  ASSERT_EQ(many.size(), 2u);
  EXPECT_EQ(many[0].size(), static_cast<std::size_t>(kChunkJobsMax));
}

TEST(SlurmTimeLimit, FollowsTheEstimateAndDoublesWithAttempts) {
  SlurmSettings settings;
  settings.time_factor = 4.0;
  settings.time_min = std::chrono::seconds(100);
  settings.time_max = std::chrono::seconds(1000);
  EXPECT_EQ(time_limit(settings, 1.0, 1).count(), 100);
  EXPECT_EQ(time_limit(settings, 50.0, 1).count(), 200);
  EXPECT_EQ(time_limit(settings, 50.0, 3).count(), 800);
  EXPECT_EQ(time_limit(settings, 50.0, 100).count(), 1000);
  EXPECT_EQ(time_limit(settings, -1.0, 1).count(), 1000) << "nothing is known";
}

TEST(SlurmParts, AreNamedAsTheirOptionsAre) {
  EXPECT_TRUE(parse_part("").is_whole());
  EXPECT_EQ(parse_part("").option(), "");
  EXPECT_EQ(parse_part("3/8").option(), "--shard=3/8");
  EXPECT_TRUE(parse_part("3/8").is_band());
  EXPECT_FALSE(parse_part("0/8").is_band());
  EXPECT_FALSE(parse_part("0/8").is_whole());
  EXPECT_EQ(parse_part("merge 8").option(), "--merge=8");
  EXPECT_FALSE(parse_part("merge 8").is_band());
  for (const char* name : {"", "0/8", "3/8", "merge 8"}) EXPECT_EQ(parse_part(name).name(), name);
  for (const char* name : {"3", "merge", "3/8 ", "99999/8"}) EXPECT_TRUE(parse_part(name).is_whole()) << name;
}

std::vector<std::vector<std::string>> names_of(const std::vector<std::vector<SlurmPart>>& batches) {
  std::vector<std::vector<std::string>> names;
  for (const std::vector<SlurmPart>& batch : batches) {
    names.emplace_back();
    for (const SlurmPart& part : batch) names.back().push_back(part.share);
  }
  return names;
}

TEST(SlurmShares, AreThreeBatchesOrFewer) {
  using Names = std::vector<std::vector<std::string>>;
  SlurmPart of_job;
  of_job.job = 7;
  of_job.attempt = 4;
  of_job.round = 2;
  const auto batches = [&](const std::vector<int>& missing) {
    return share_batches(of_job, 3, missing, kAnyArraySize);
  };
  EXPECT_EQ(names_of(batches({0, 1, 2, 3})), (Names{{"0/3"}, {"1/3", "2/3", "3/3"}, {"merge 3"}}));
  EXPECT_EQ(names_of(batches({2})), (Names{{"2/3"}, {"merge 3"}}));
  EXPECT_EQ(names_of(batches({})), (Names{{"merge 3"}}));
  const SlurmPart part = batches({2}).front().front();
  EXPECT_EQ(part.item, 2) << "of the array";
  EXPECT_EQ(part.job, 7);
  EXPECT_EQ(part.attempt, 4);
  EXPECT_EQ(part.round, 2);
}

std::vector<std::vector<int>> items_of(const std::vector<std::vector<SlurmPart>>& batches) {
  std::vector<std::vector<int>> items;
  for (const std::vector<SlurmPart>& batch : batches) {
    items.emplace_back();
    for (const SlurmPart& part : batch) items.back().push_back(part.item);
  }
  return items;
}

TEST(SlurmShares, ArraysStayBelowMaxArraySize) {
  using Names = std::vector<std::vector<std::string>>;
  using Items = std::vector<std::vector<int>>;
  const auto batches = [](int count, const std::vector<int>& missing, int array_size_max) {
    return share_batches({}, count, missing, array_size_max);
  };
  EXPECT_EQ(items_of(batches(3, {0, 1, 2, 3}, 4)), (Items{{0}, {1, 2, 3}, {0}}))
      << "items keep their own numbers if these fit";
  EXPECT_EQ(names_of(batches(3, {0, 1, 2, 3}, 3)), (Names{{"0/3"}, {"1/3", "2/3", "3/3"}, {"merge 3"}}));
  EXPECT_EQ(items_of(batches(3, {0, 1, 2, 3}, 3)), (Items{{0}, {0, 1, 2}, {0}}));
  EXPECT_EQ(names_of(batches(5, {1, 2, 3, 4, 5}, 2)), (Names{{"1/5", "2/5"}, {"3/5", "4/5"}, {"5/5"}, {"merge 5"}}));
  EXPECT_EQ(items_of(batches(5, {1, 2, 3, 4, 5}, 2)), (Items{{0, 1}, {0, 1}, {0}, {0}}));
  EXPECT_EQ(items_of(batches(200, {150}, 5)), (Items{{0}, {0}})) << "a single item whose own number is too high gets 0";
  EXPECT_EQ(items_of(batches(3, {1, 2, 3}, 1)), (Items{{0}, {0}, {0}, {0}}));
}

TEST(SlurmShares, WaitForThoseBefore) {
  const PartKind zero = parse_part("0/3"), band = parse_part("2/3"), merge = parse_part("merge 3"), whole;
  EXPECT_TRUE(waits_for(band, zero));
  EXPECT_TRUE(waits_for(merge, zero));
  EXPECT_TRUE(waits_for(merge, band));
  EXPECT_FALSE(waits_for(band, band));
  EXPECT_FALSE(waits_for(zero, band));
  EXPECT_FALSE(waits_for(band, merge));
  EXPECT_FALSE(waits_for(merge, merge));
  EXPECT_FALSE(waits_for(whole, zero));
  EXPECT_FALSE(waits_for(merge, whole));
}

TEST(Sbatch, SaysWhetherItMayTakeIt) {
  const auto failed = [](const std::string& why) {
    return refusal_of("sbatch: sbatch: error: Batch job submission failed: " + why);
  };
  for (const char* why :
       {"Unable to contact slurm controller (connect failure)", "Socket timed out on send/recv operation",
        "Slurm temporarily unable to accept job, sleeping and retrying", "Slurm backup controller in standby mode",
        "Unable to create job record, try again", "Zero Bytes were transmitted or received",
        "Required partition not available (inactive or drain)", "Invalid job credential"})
    EXPECT_EQ(failed(why), SlurmRefusal::kNotNow) << why;
  EXPECT_EQ(refusal_of("sbatch did not end within 60 s"), SlurmRefusal::kNotNow);
  EXPECT_EQ(refusal_of("sbatch: sbatch: fatal: Could not establish a configuration source"), SlurmRefusal::kNotNow);
  for (const char* why :
       {"Invalid account or account/partition combination specified", "Invalid partition name specified",
        "Invalid qos specification", "User's group not permitted to use this partition", "Access/permission denied",
        "Requested node configuration is not available",
        "Requested time limit is invalid (missing or exceeds some limit)"})
    EXPECT_EQ(failed(why), SlurmRefusal::kNever) << why;
  EXPECT_EQ(refusal_of("sbatch: sbatch: unrecognized option '--qso=low'; Try \"sbatch --help\" for more information"),
            SlurmRefusal::kNever);
  EXPECT_EQ(failed("Invalid job array specification"), SlurmRefusal::kArrayTooLong);
  EXPECT_EQ(failed("Job violates accounting/QOS policy (job submit limit, user's size and/or time limits)"),
            SlurmRefusal::kUnknown)
      << "other jobs may end, or the job may always be too large";
  EXPECT_EQ(failed("a text of another version"), SlurmRefusal::kUnknown);
}

TEST(Scontrol, TellsTheSizeOfArrays) {
  EXPECT_EQ(parse_array_size_max("Configuration data as of 2026\nMaxArraySize            = 1001\nMaxDBDMsgs = 20084\n"),
            1001);
  EXPECT_EQ(parse_array_size_max("MaxArraySize            = 0\n"), 0);
  EXPECT_EQ(parse_array_size_max("MaxArraySizes = 5\n"), std::nullopt);
  EXPECT_EQ(parse_array_size_max("slurm_load_ctl_conf error: Unable to contact slurm controller\n"), std::nullopt);
}

TEST(SlurmShares, MergesNameWhatTheyLack) {
  EXPECT_EQ(named_shares("a.shard-1-of-3: is not there; --shard 1/3 makes it\nb: damaged; --shard 3/3 makes it", 3),
            (std::vector<int>{1, 3}));
  EXPECT_EQ(named_shares("--shard 1/4 makes it, --shard 9/3 too", 3), std::vector<int>{});
}

TEST(Squeue, ListsTasks) {
  const std::vector<SlurmTask> tasks = parse_squeue(
      "12|N/A|RUNNING|bake1|multum-ab-17|None\n13|3|PENDING||multum-ab-18|Resources\nslurm_load_jobs error\n\n"
      "14|1|COMPLETED|bake2|odd|name|None\n");
  ASSERT_EQ(tasks.size(), 3u);
  EXPECT_EQ(tasks[0].job, 12);
  EXPECT_EQ(tasks[0].item, -1);
  EXPECT_EQ(tasks[0].node, "bake1");
  EXPECT_EQ(tasks[0].name, "multum-ab-17");
  EXPECT_EQ(tasks[1].item, 3);
  EXPECT_EQ(tasks[1].reason, "Resources");
  EXPECT_FALSE(tasks[1].is_over());
  EXPECT_TRUE(tasks[2].is_over());
  EXPECT_TRUE((SlurmTask{1, -1, "", "PENDING", "launch failed requeued held", ""}).is_stuck());
}

TEST(SlurmBatch, RefusesTheOrderOfAnotherMultum) {
  const testing::TemporaryFolder folder;
  const SlurmFolder all(folder.path(), "0a1b");
  all.prepare();
  const SlurmBatchFolder batch = all.batch(17);
  batch.write_order({});
  testing::write_bytes(batch.path() + "/order.json",
                       R"({"is_array": true, "roots": [], "items": [{"arguments": []}]})");
  testing::expect_error(ErrorCode::kEnvironment, {"order.json", "will send its jobs again"},
                        [&] { batch.read_order(); });
}

TEST(SlurmBatch, SaysOnEitherSideWhatTheOtherWrote) {
  const testing::TemporaryFolder folder;
  const SlurmFolder all(folder.path(), "0a1b");
  all.prepare();
  const SlurmBatchFolder batch = all.batch(17);
  EXPECT_FALSE(batch.has_order());
  SlurmOrder order;
  order.is_array = true;
  order.roots = {"/a b", "/c"};
  order.threads = 3;
  WorkOrder work;
  work.job = 5;
  work.attempt = 2;
  work.type = "bake";
  work.parameters = {{"input", "/a b/\"x\".png"}, {"lobes", 4}};
  work.share = "--shard=3/8";
  work.folder = "/a b/.multum-0a1b-5";
  order.items = {{3, work}};
  batch.write_order(order);
  EXPECT_EQ(all.batches(), std::vector<std::int64_t>{17});
  const SlurmOrder read = batch.read_order();
  EXPECT_TRUE(read.is_array);
  EXPECT_EQ(read.roots, order.roots);
  EXPECT_EQ(read.threads, 3);
  ASSERT_EQ(read.items.size(), 1u);
  EXPECT_EQ(read.items[0].number, 3);
  EXPECT_EQ(read.items[0].work.type, work.type);
  EXPECT_EQ(read.items[0].work.parameters, work.parameters);
  EXPECT_EQ(read.items[0].work.share, work.share);
  EXPECT_EQ(read.items[0].work.folder, work.folder);

  EXPECT_FALSE(batch.status(3) || batch.end(3) || batch.is_stopped(3));
  batch.write_status(3, {9, "bake1", {"fit", 2, 4}});
  batch.write_end(3, {{-1, "its worker died", true}, "bake2"});
  batch.stop(3);
  EXPECT_EQ(batch.status(3)->beat, 9u);
  EXPECT_EQ(batch.status(3)->progress.stage, "fit");
  EXPECT_EQ(batch.end(3)->result.exit_code, -1);
  EXPECT_TRUE(batch.end(3)->result.have_inputs_changed);
  EXPECT_EQ(batch.end(3)->node, "bake2");
  EXPECT_TRUE(batch.is_stopped(3));
  testing::write_bytes(folder / "multum-0a1b/batch-17/ended-4.json", "{\"exit_code\": ");
  EXPECT_FALSE(batch.end(4)) << "cut";

  batch.revoke_order();
  EXPECT_FALSE(batch.has_order());
  EXPECT_THROW(batch.read_order(), Error);
  all.remove(17);
  EXPECT_TRUE(all.batches().empty());
}

TEST(SlurmBatch, LogsAreGatheredLineByLine) {
  const testing::TemporaryFolder folder;
  const SlurmFolder all(folder.path(), "0a1b");
  all.prepare();
  const SlurmBatchFolder batch = all.batch(1);
  batch.write_order({});
  batch.make_work_folder(3);
  const std::string to = folder / "5.log";
  testing::write_bytes(batch.log(3, 3), "one\ntw");
  batch.move_log(3, 3, to, "share 3/8: ", false);
  EXPECT_EQ(testing::read_bytes(to), "share 3/8: one\n");
  testing::write_bytes(batch.log(3, 3), "one\ntwo\nend");
  batch.move_log(3, 3, to, "share 3/8: ", true);
  batch.move_log(3, 3, to, "share 3/8: ", true);
  EXPECT_EQ(testing::read_bytes(to), "share 3/8: one\nshare 3/8: two\nshare 3/8: end\n");
}

class SlurmLedgerTest : public ::testing::Test {
 protected:
  void SetUp() override { open(); }
  void open() {
    queue_.reset();
    LedgerSettings settings;
    settings.path = folder_ / "jobs.sqlite";
    queue_ = std::make_unique<JobQueue>(settings);
  }
  std::int64_t submit(const std::string& type, std::int64_t memory = 0) {
    JobSubmission s;
    s.type = type;
    s.memory_bytes = memory;
    return queue_
        ->submit(
            s, [](const Job&) { return false; }, 1)
        .id;
  }
  static SlurmPart part_of(const Job& job, std::int64_t batch) {
    SlurmPart part;
    part.batch = batch;
    part.job = job.id;
    part.attempt = job.attempt;
    return part;
  }

  const std::string owner_ = slurm_owner("0a1b");
  ClaimLimits limits_{{{"default", {}}}, {}, 0};
  const testing::TemporaryFolder folder_;
  std::unique_ptr<JobQueue> queue_;
};

TEST_F(SlurmLedgerTest, WhatSlurmHasOutlivesTheDaemon) {
  submit("drill");
  submit("drill");
  submit("drill");
  const Job sent = *queue_->claim(limits_, owner_, 2), claimed = *queue_->claim(limits_, owner_, 2),
            local = *queue_->claim(limits_, "0a1b:77:1", 2);
  queue_->slurm().add(part_of(sent, 40));
  queue_->slurm().set_slurm_job(40, 12);
  open();
  const JobQueue::Recovered recovered = queue_->recover(3, true);
  ASSERT_EQ(recovered.with_slurm.size(), 1u);
  EXPECT_EQ(recovered.with_slurm[0].id, sent.id);
  EXPECT_EQ(queue_->find(sent.id)->state, JobState::kRunning);
  EXPECT_EQ(queue_->find(claimed.id)->state, JobState::kQueued);
  EXPECT_EQ(queue_->attempts(claimed.id)[0].outcome, AttemptOutcome::kReturned) << "nobody had begun it";
  EXPECT_EQ(queue_->attempts(local.id)[0].outcome, AttemptOutcome::kLost);
  ASSERT_EQ(queue_->slurm().sent().size(), 1u);
  EXPECT_EQ(queue_->slurm().sent()[0].slurm_job, 12);
  EXPECT_EQ(queue_->slurm().last_batch(), 40);
  // The end of an attempt in Slurm counts like the end of any other attempt.
  EXPECT_TRUE(queue_->ended(sent.id, owner_, sent.attempt, {}, 4));
  EXPECT_EQ(queue_->find(sent.id)->state, JobState::kSucceeded);
}

TEST_F(SlurmLedgerTest, WhatWasAskedToStopIsCancelledByTheNextDaemon) {
  const std::int64_t id = submit("drill");
  const Job sent = *queue_->claim(limits_, owner_, 2);
  queue_->slurm().add(part_of(sent, 40));
  EXPECT_EQ(queue_->cancel(id, "by request", 3), CancelResult::kStopWorker);
  EXPECT_TRUE(queue_->recover(4, true).with_slurm.empty());
  EXPECT_EQ(queue_->find(id)->state, JobState::kCancelled);
  EXPECT_TRUE(queue_->slurm().sent().empty());
}

TEST_F(SlurmLedgerTest, WithoutSlurmItIsLost) {
  submit("drill");
  const Job sent = *queue_->claim(limits_, owner_, 2);
  queue_->slurm().add(part_of(sent, 40));
  EXPECT_TRUE(queue_->recover(3).with_slurm.empty());
  EXPECT_EQ(queue_->find(sent.id)->state, JobState::kQueued);
  EXPECT_TRUE(queue_->slurm().sent().empty());
  EXPECT_EQ(queue_->slurm().of_job(sent.id)[0].state, SlurmPartState::kCancelled);
}

TEST_F(SlurmLedgerTest, PartsAreKeptUntilTheirJobIsPurged) {
  const std::int64_t id = submit("drill");
  const Job job = *queue_->claim(limits_, owner_, 2);
  SlurmPart part = part_of(job, 40);
  queue_->slurm().add(part);
  part.state = SlurmPartState::kFailed;
  part.node = "bake1";
  part.exit_code = 4;
  part.message = "no disk";
  queue_->slurm().update(part);
  EXPECT_TRUE(queue_->slurm().sent().empty());
  const SlurmPart kept = queue_->slurm().of_job(id)[0];
  EXPECT_EQ(kept.state, SlurmPartState::kFailed);
  EXPECT_EQ(kept.node, "bake1");
  EXPECT_EQ(kept.exit_code, 4);
  EXPECT_EQ(kept.message, "no disk");
  queue_->ended(id, owner_, job.attempt, {}, 3);
  queue_->purge({id});
  EXPECT_TRUE(queue_->slurm().of_job(id).empty());
}

TEST_F(SlurmLedgerTest, ItsJobsTakeNoneOfThisMachinesMemory) {
  submit("drill", 100);
  submit("drill", 100);
  limits_.memory_max = 150;
  EXPECT_TRUE(queue_->claim({limits_.queues, {}, 0}, owner_, 2));
  EXPECT_TRUE(queue_->claim(limits_, "0a1b:77:1", 2));
  submit("drill", 100);
  EXPECT_FALSE(queue_->claim(limits_, "0a1b:77:2", 2));
}

TEST_F(SlurmLedgerTest, TypesOfAQueueAreToldApart) {
  const std::int64_t drill = submit("drill"), bake = submit("bake"), scene = submit("scene");
  QueueLimits those, others;
  those.types = others.types = R"(["bake","scene"])";
  others.are_types_left = true;
  const ClaimLimits for_slurm{{{"default", those}}, {}, 0}, here{{{"default", others}}, {}, 0};
  EXPECT_EQ(queue_->claim(for_slurm, owner_, 2)->id, bake);
  EXPECT_EQ(queue_->claim(here, "0a1b:77:1", 2)->id, drill);
  EXPECT_FALSE(queue_->claim(here, "0a1b:77:1", 2));
  EXPECT_EQ(queue_->claim(for_slurm, owner_, 2)->id, scene);
}

TEST_F(SlurmLedgerTest, ALedgerOfVersionFourIsTakenOver) {
  const std::int64_t id = submit("drill");
  queue_->database().execute("DROP TABLE slurm_parts; DROP INDEX jobs_listed; PRAGMA user_version = 4;");
  open();
  EXPECT_EQ(queue_->find(id)->state, JobState::kQueued);
  EXPECT_TRUE(queue_->slurm().sent().empty());
}

}  // namespace
}  // namespace multum
