// SPDX-License-Identifier: Apache-2.0
// Tests ledgers with damage in random pages. Rescued jobs must equal the original jobs, and the new ledger must be
// intact.
#include "host/farm/service/ledger/ledger_rescue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>

#include "host/farm/service/files/data_lock.h"
#include "host/farm/service/ledger/ledger_start.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::expect_error;
using testing::TemporaryFolder;

constexpr std::size_t kPageBytes = 4096;
constexpr int kJobs = 3000;

// Makes jobs in every state, as in a folder that a daemon has used.
std::map<std::int64_t, Job> make_ledger(const std::string& data, int job_count = kJobs) {
  fs::create_directory(data);
  QueueThread ledger(find_ledger(data, {}, false), [](const std::function<void()>& task) { task(); });
  take_up_ledger(ledger, data);
  std::map<std::int64_t, Job> jobs;
  ledger.run_now([&](JobQueue& queue) {
    const ClaimLimits limits = {{{"default", {}}}, {}, 0};
    for (int i = 0; i < job_count; ++i) {
      JobSubmission submission;
      submission.type = "bake";
      submission.label = "job " + std::to_string(i);
      submission.parameters = "{\"input\":\"/maps/" + std::string(static_cast<std::size_t>(i % 60), 'x') + "\"}";
      if (i % 7 == 6) submission.needs = {i, i - 3};
      queue.submit(submission, nullptr, 1);
    }
    for (int i = 0; i < job_count / 2; ++i) {
      const Job job = *queue.claim(limits, "worker", 2);
      if (i % 5 == 4) continue;
      const AttemptOutcome outcome = i % 11 == 3 ? AttemptOutcome::kRefused : AttemptOutcome::kSucceeded;
      queue.ended(job.id, "worker", job.attempt, {outcome, 0, "said"}, 3);
    }
    queue.files().note_upload("/uploads/a");
    for (std::int64_t id = 1; id <= job_count; ++id) jobs[id] = *queue.find(id);
  });
  return jobs;
}

void damage(const std::string& path, const std::vector<std::size_t>& pages, std::mt19937& random) {
  std::string bytes = testing::read_bytes(path);
  for (const std::size_t page : pages)
    for (std::size_t i = 0; i < kPageBytes; ++i) bytes[page * kPageBytes + i] = static_cast<char>(random());
  testing::write_bytes(path, bytes);
}

// Opens the rescued ledger as a daemon would, and returns its jobs.
std::map<std::int64_t, Job> open_rescued(const std::string& data, int job_count = kJobs) {
  JobQueue queue(find_ledger(data, {}, false));
  EXPECT_EQ(queue.database().damage(), "");
  std::map<std::int64_t, Job> jobs;
  for (std::int64_t id = 1; id <= job_count; ++id)
    if (const std::optional<Job> job = queue.find(id)) jobs[id] = *job;
  const SqliteTransaction transaction(queue.database());  // otherwise each row would have to wait for the disk
  EXPECT_GT(queue.submit({}, nullptr, 4).id, job_count) << "a job number was reused";
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
  EXPECT_EQ(testing::read_bytes(report.kept), bytes) << "the damaged ledger is kept unchanged";
  for (const RescueReport::Table& table : report.tables) EXPECT_EQ(table.damaged, 0) << table.name;
  EXPECT_EQ(report.tables.front().saved, kJobs);
  const std::map<std::int64_t, Job> after = open_rescued(data);
  ASSERT_EQ(after.size(), before.size());
  for (const auto& [id, job] : before) {
    EXPECT_EQ(after.at(id).state, job.state);
    EXPECT_EQ(after.at(id).needs, job.needs);
  }
  // A repeated rescue does not overwrite any file.
  EXPECT_NE(rescue_ledger(data).kept, report.kept);
  EXPECT_EQ(testing::read_bytes(report.kept), bytes);
}

TEST(LedgerRescue, SavesOneFromBeforeAField) {
  const TemporaryFolder folder;
  const std::string data = folder / "data";
  make_ledger(data, 20);
  SqliteDatabase(data + "/jobs.sqlite").execute("ALTER TABLE jobs DROP COLUMN stop_asked");
  EXPECT_EQ(rescue_ledger(data).tables.front().saved, 20);
  EXPECT_EQ(open_rescued(data, 20).size(), 20u);
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
    std::vector<std::size_t> pages = {i < 2 ? 0 : random() % page_count};  // the first page contains the list of tables
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
  // A page holds about 20 jobs. If the root page of all jobs were damaged, all jobs would be lost. It is one page in
  // hundreds, and this seed does not damage it.
  EXPECT_GT(sum, before.size() * kTries * 9 / 10);
}

void expect_nothing_left(const std::string& data) {
  for (const char* made : {".copy", ".rescued"})
    for (const char* part : {"", "-wal", "-shm", "-journal"})
      EXPECT_FALSE(fs::exists(data + "/jobs.sqlite" + made + part)) << made << part;
}

// Damages a file in one of many ways: changes bytes, bits or pages, or cuts off the end.
std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t end) { return static_cast<std::size_t>(random() % end); };
  const std::size_t pages = bytes.size() / kPageBytes, page = below(pages) * kPageBytes,
                    other = below(pages) * kPageBytes;
  switch (random() % 7) {
    case 0:
      for (std::size_t i = 0, count = 1 + below(200); i < count; ++i)
        bytes[below(bytes.size())] = static_cast<char>(random());
      break;
    case 1:
      for (std::size_t i = 0, count = 1 + below(400); i < count; ++i)
        bytes[below(bytes.size())] ^= static_cast<char>(1 << below(8));
      break;
    case 2: std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(page), kPageBytes, '\0'); break;
    case 3:
      std::swap_ranges(bytes.begin() + static_cast<std::ptrdiff_t>(page),
                       bytes.begin() + static_cast<std::ptrdiff_t>(page + kPageBytes),
                       bytes.begin() + static_cast<std::ptrdiff_t>(other));
      break;
    case 4: bytes.resize(1 + below(bytes.size())); break;
    case 5:
      for (std::size_t i = 0; i < 100; ++i) bytes[below(120)] = static_cast<char>(random());  // the file's header
      break;
    default:
      for (std::size_t i = 0; i < 30; ++i)
        bytes[page + below(16)] = static_cast<char>(random());  // the header of a page
  }
  return bytes;
}

TEST(LedgerRescue, AnyDamageIsRescuedOrRefusedClearly) {
  constexpr int kFew = 300;
  const TemporaryFolder folder;
  const std::map<std::int64_t, Job> before = make_ledger(folder / "whole", kFew);
  const std::string whole = testing::read_bytes(folder / "whole/jobs.sqlite");
  int rescued = 0;
  constexpr int kSeeds = 80;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const std::string data = folder / std::to_string(seed);
    fs::copy(folder / "whole", data, fs::copy_options::recursive);
    const std::string bytes = damaged(whole, random);
    testing::write_bytes(data + "/jobs.sqlite", bytes);
    try {
      const RescueReport report = rescue_ledger(data);
      EXPECT_EQ(testing::read_bytes(report.kept), bytes);
      EXPECT_EQ(static_cast<std::int64_t>(open_rescued(data, kFew).size()), report.tables.front().saved);
      ++rescued;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kInput) << error.what();
      testing::expect_says(error.what(), {"jobs.sqlite", "--new-ledger"});
      EXPECT_EQ(testing::read_bytes(data + "/jobs.sqlite"), bytes);
    }
    expect_nothing_left(data);
    fs::remove_all(data);
    if (::testing::Test::HasFailure()) return;
  }
  EXPECT_GT(rescued, kSeeds * 3 / 4);
}

// If a ledger does not accept a value, or if a function of SQLite fails for it, only the row with this value is lost.
TEST(LedgerRescue, OneBadRowCostsThatRow) {
  for (const char* damage :
       {"UPDATE jobs SET parameters = x'7b00ff7d' WHERE id = 5", "UPDATE jobs SET state = 99 WHERE id = 5",
        "UPDATE jobs SET parameters = '{\"a\":' WHERE id = 5", "UPDATE jobs SET queue = x'00' WHERE id = 5",
        "UPDATE jobs SET label = CAST(x'ff' AS TEXT) WHERE id = 5"}) {
    SCOPED_TRACE(damage);
    const TemporaryFolder folder;
    make_ledger(folder / "d", 20);
    {
      SqliteDatabase ledger(folder / "d/jobs.sqlite");
      ledger.execute("PRAGMA ignore_check_constraints = ON");
      ledger.execute(damage);
    }
    const RescueReport report = rescue_ledger(folder / "d");
    EXPECT_EQ(report.tables.front().saved, 19);
    EXPECT_EQ(report.tables.front().damaged, 1);
    EXPECT_FALSE(open_rescued(folder / "d", 20).contains(5));
    expect_nothing_left(folder / "d");
  }
}

TEST(LedgerRescue, AnEmptyLedgerLeavesNothingBehind) {
  const TemporaryFolder folder;
  make_ledger(folder / "d", 1);
  {
    SqliteDatabase ledger(folder / "d/jobs.sqlite");
    ledger.execute("DELETE FROM jobs; DELETE FROM uploads");
  }
  // Tests an intact ledger without jobs.
  const RescueReport report = rescue_ledger(folder / "d");
  EXPECT_EQ(report.tables.front().saved, 0);
  EXPECT_EQ(report.tables.front().damaged, 0);
  expect_nothing_left(folder / "d");
  EXPECT_TRUE(open_rescued(folder / "d", 1).empty());
  // Tests an empty file, and a database without tables.
  testing::write_bytes(folder / "d/jobs.sqlite", "");
  expect_error(ErrorCode::kInput, {folder / "d/jobs.sqlite", "empty", "--new-ledger"},
               [&] { rescue_ledger(folder / "d"); });
  expect_nothing_left(folder / "d");
  EXPECT_EQ(testing::read_bytes(folder / "d/jobs.sqlite"), "");
  fs::remove(folder / "d/jobs.sqlite");
  { SqliteDatabase(folder / "d/jobs.sqlite").execute("CREATE TABLE other (a)"); }
  expect_error(ErrorCode::kInput, {folder / "d/jobs.sqlite", "no job"}, [&] { rescue_ledger(folder / "d"); });
  expect_nothing_left(folder / "d");
}

TEST(LedgerRescue, RefusesWithoutTouchingAnything) {
  const TemporaryFolder folder;
  expect_error(ErrorCode::kInput, {folder / "none/jobs.sqlite", "missing"}, [&] { rescue_ledger(folder / "none"); });
  EXPECT_FALSE(fs::exists(folder / "none"));
  fs::create_directory(folder / "data");
  testing::write_bytes(folder / "data/jobs.sqlite", std::string(9000, 'x'));
  expect_error(ErrorCode::kInput, {folder / "data/jobs.sqlite"}, [&] { rescue_ledger(folder / "data"); });
  EXPECT_EQ(testing::read_bytes(folder / "data/jobs.sqlite"), std::string(9000, 'x'));
  expect_nothing_left(folder / "data");
  const auto lock = DataLock::take(folder / "data");
  expect_error(ErrorCode::kEnvironment, {folder / "data", "daemon"}, [&] { rescue_ledger(folder / "data"); });
}

}  // namespace
}  // namespace multum
