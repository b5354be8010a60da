// SPDX-License-Identifier: Apache-2.0
// Ledgers damaged in random pages: what is saved is what was there, in a ledger that is whole.
#include "host/service/ledger/ledger_rescue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>

#include "host/service/files/data_lock.h"
#include "host/service/ledger/ledger_start.h"
#include "tests/unit/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::expect_error;
using testing::TemporaryFolder;

constexpr std::size_t kPageBytes = 4096;
constexpr int kJobs = 3000;

// Jobs in all states, as a folder that a daemon has used.
std::map<std::int64_t, Job> make_ledger(const std::string& data) {
  fs::create_directory(data);
  QueueThread ledger(find_ledger(data, {}, false), [](const std::function<void()>& task) { task(); });
  take_up_ledger(ledger, DataFolder(data, 0), data);
  std::map<std::int64_t, Job> jobs;
  ledger.run_now([&](JobQueue& queue) {
    const ClaimLimits limits = {{{"default", {}}}, {}, 0};
    for (int i = 0; i < kJobs; ++i) {
      JobSubmission submission;
      submission.type = "bake";
      submission.label = "job " + std::to_string(i);
      submission.parameters = "{\"input\":\"/maps/" + std::string(static_cast<std::size_t>(i % 60), 'x') + "\"}";
      if (i % 7 == 6) submission.needs = {i, i - 3};
      queue.submit(submission, nullptr, 1);
    }
    for (int i = 0; i < kJobs / 2; ++i) {
      const Job job = *queue.claim(limits, "worker", 2);
      if (i % 5 == 4) continue;
      const AttemptOutcome outcome = i % 11 == 3 ? AttemptOutcome::kRefused : AttemptOutcome::kSucceeded;
      queue.ended(job.id, "worker", job.attempt, {outcome, 0, "said"}, 3);
    }
    queue.files().note_upload("/uploads/a");
    for (std::int64_t id = 1; id <= kJobs; ++id) jobs[id] = *queue.find(id);
  });
  return jobs;
}

void damage(const std::string& path, const std::vector<std::size_t>& pages, std::mt19937& random) {
  std::string bytes = testing::read_bytes(path);
  for (const std::size_t page : pages)
    for (std::size_t i = 0; i < kPageBytes; ++i) bytes[page * kPageBytes + i] = static_cast<char>(random());
  testing::write_bytes(path, bytes);
}

// What is there by now, as a daemon would go on with it.
std::map<std::int64_t, Job> open_rescued(const std::string& data) {
  JobQueue queue(find_ledger(data, {}, false));
  EXPECT_EQ(queue.database().damage(), "");
  std::map<std::int64_t, Job> jobs;
  for (std::int64_t id = 1; id <= kJobs; ++id)
    if (const std::optional<Job> job = queue.find(id)) jobs[id] = *job;
  const SqliteTransaction transaction(queue.database());  // or each row would wait for the disk
  EXPECT_GT(queue.submit({}, nullptr, 4).id, kJobs) << "a number was used again";
  queue.recover(5);
  for (const auto& [queue_name, states] : queue.counts()) EXPECT_FALSE(states.contains(JobState::kRunning));
  return jobs;
}

void expect_of(const std::map<std::int64_t, Job>& before, const std::map<std::int64_t, Job>& after) {
  for (const auto& [id, job] : after) {
    const Job& old = before.at(id);
    EXPECT_EQ(job.parameters, old.parameters) << id;
    EXPECT_EQ(job.label, old.label) << id;
    if (job.state != old.state) {
      EXPECT_EQ(job.state, JobState::kDead) << id;
      EXPECT_EQ(old.state, JobState::kWaiting) << id;
    }
    for (const std::int64_t need : job.needs)
      EXPECT_TRUE(std::find(old.needs.begin(), old.needs.end(), need) != old.needs.end()) << id;
  }
}

TEST(LedgerRescue, SavesAllOfAWholeOne) {
  const TemporaryFolder folder;
  const std::string data = folder / "data";
  const std::map<std::int64_t, Job> before = make_ledger(data);
  const std::string bytes = testing::read_bytes(data + "/jobs.sqlite");
  const RescueReport report = rescue_ledger(data);
  EXPECT_EQ(testing::read_bytes(report.kept), bytes) << "the old one is kept as it was";
  for (const RescueReport::Table& table : report.tables) EXPECT_EQ(table.damaged, 0) << table.name;
  EXPECT_EQ(report.tables.front().saved, kJobs);
  const std::map<std::int64_t, Job> after = open_rescued(data);
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [id, job] : before) {
    EXPECT_EQ(after.at(id).state, job.state);
    EXPECT_EQ(after.at(id).needs, job.needs);
  }
  // Nothing is written over, however often.
  EXPECT_NE(rescue_ledger(data).kept, report.kept);
  EXPECT_EQ(testing::read_bytes(report.kept), bytes);
}

TEST(LedgerRescue, SavesWhatIsOnOtherPages) {
  const unsigned seed = 20261123;
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  const TemporaryFolder folder;
  const std::map<std::int64_t, Job> before = make_ledger(folder / "whole");
  const std::size_t page_count = fs::file_size(folder / "whole/jobs.sqlite") / kPageBytes;
  ASSERT_GT(page_count, 100u);
  std::size_t least = before.size(), sum = 0;
  constexpr int kTries = 15;
  for (int i = 0; i < kTries; ++i) {
    const std::string data = folder / std::to_string(i);
    fs::copy(folder / "whole", data, fs::copy_options::recursive);
    std::vector<std::size_t> pages = {i < 2 ? 0 : random() % page_count};  // the first: the list of the tables
    if (i % 2 == 0) pages.push_back(random() % page_count);
    damage(data + "/jobs.sqlite", pages, random);
    SCOPED_TRACE(pages.front());
    SCOPED_TRACE(pages.back());
    const RescueReport report = rescue_ledger(data);
    const std::map<std::int64_t, Job> after = open_rescued(data);
    EXPECT_EQ(static_cast<std::int64_t>(after.size()), report.tables.front().saved);
    expect_of(before, after);
    least = std::min(least, after.size());
    sum += after.size();
    if (::testing::Test::HasFailure()) return;
  }
  RecordProperty("least_saved", static_cast<int>(least));
  // A page holds some 20 jobs. The one above all pages of jobs would cost all: one in hundreds, and none for this seed.
  EXPECT_GT(sum, before.size() * kTries * 9 / 10);
}

TEST(LedgerRescue, RefusesWithoutTouchingAnything) {
  const TemporaryFolder folder;
  expect_error(ErrorCode::kInput, {folder / "none/jobs.sqlite", "missing"}, [&] { rescue_ledger(folder / "none"); });
  EXPECT_FALSE(fs::exists(folder / "none"));
  fs::create_directory(folder / "data");
  testing::write_bytes(folder / "data/jobs.sqlite", std::string(9000, 'x'));
  expect_error(ErrorCode::kInput, {folder / "data/jobs.sqlite"}, [&] { rescue_ledger(folder / "data"); });
  EXPECT_EQ(testing::read_bytes(folder / "data/jobs.sqlite"), std::string(9000, 'x'));
  EXPECT_FALSE(fs::exists(folder / "data/jobs.sqlite.rescued"));
  const auto lock = DataLock::take(folder / "data");
  expect_error(ErrorCode::kEnvironment, {folder / "data", "daemon"}, [&] { rescue_ledger(folder / "data"); });
}

}  // namespace
}  // namespace multum
