// SPDX-License-Identifier: Apache-2.0
// Tests with which ledger a daemon continues. A folder that was in use has its own ledger or no ledger.
#include "host/farm/service/ledger/ledger_start.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "host/farm/service/dispatch/data_folder.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::expect_error;
using testing::TemporaryFolder;

class LedgerStartTest : public ::testing::Test {
 protected:
  // Starts a daemon, adds a job and returns its number.
  std::int64_t start(bool begins_anew = false) {
    const LedgerSettings settings = find_ledger(folder_.path(), {}, begins_anew);
    const DataFolder folders(folder_.path(), 0);  // makes folders for logs, uploads and results
    QueueThread ledger(settings, [](const std::function<void()>& task) { task(); });
    instance_ = take_up_ledger(ledger, folder_.path());
    std::int64_t id = 0;
    ledger.run_now([&](JobQueue& queue) {
      JobSubmission submission;
      submission.type = "drill";
      id = queue.submit(submission, nullptr, 1).id;
    });
    return id;
  }
  std::string path() const { return folder_ / "jobs.sqlite"; }

  TemporaryFolder folder_;
  std::string instance_;
};

TEST_F(LedgerStartTest, GoesOnWithItsOwn) {
  EXPECT_EQ(start(), 1);
  const std::string first = instance_;
  EXPECT_EQ(first.size(), 8u);
  EXPECT_EQ(testing::read_bytes(folder_ / "instance"), first + "\n");
  EXPECT_EQ(start(), 2);
  EXPECT_EQ(instance_, first);
  // After an interrupted start or a deleted file, the ledger still knows its instance.
  fs::remove(folder_ / "instance");
  EXPECT_EQ(start(), 3);
  EXPECT_EQ(instance_, first);
  testing::write_bytes(folder_ / "instance", "");
  EXPECT_EQ(start(), 4);
  EXPECT_EQ(instance_, first);
  testing::write_bytes(folder_ / "instance", "");
  fs::remove(path());
  expect_error(ErrorCode::kEnvironment, {path(), "missing"}, [&] { start(); });
}

TEST_F(LedgerStartTest, AMissingEmptyOrForeignLedgerIsRefused) {
  start();
  fs::rename(path(), folder_ / "kept");
  expect_error(ErrorCode::kEnvironment, {path(), "missing", "multum serve --rescue", "--new-ledger"}, [&] { start(); });
  EXPECT_FALSE(fs::exists(path())) << "the refusal must not create a ledger";
  testing::write_bytes(path(), "");
  expect_error(ErrorCode::kEnvironment, {path(), "empty", "--new-ledger"}, [&] { start(); });
  { SqliteDatabase without_tables(path()); }
  expect_error(ErrorCode::kEnvironment, {path(), "empty", "--new-ledger"}, [&] { start(); });
  {
    LedgerSettings other;
    other.path = folder_ / "other";
    other.instance = "0123abcd";
    JobQueue{other};
  }
  fs::rename(folder_ / "other", path());
  expect_error(ErrorCode::kEnvironment, {path(), "0123abcd", instance_, "--new-ledger"}, [&] { start(); });
  fs::rename(folder_ / "kept", path());
  EXPECT_EQ(start(), 2);
}

TEST_F(LedgerStartTest, ANewOneForgetsNothingThatIsThere) {
  start();
  expect_error(ErrorCode::kUsage, {path(), "--new-ledger"}, [&] { start(true); });
  testing::write_bytes(path() + "-wal", "what was not checkpointed");
  fs::rename(path(), folder_ / "kept");
  expect_error(ErrorCode::kUsage, {path() + "-wal", "--new-ledger"}, [&] { start(true); });
  fs::remove(path() + "-wal");
  EXPECT_EQ(start(true), 257) << "a reported number may belong to a job that left no other trace";
  EXPECT_EQ(start(), 258);
}

TEST_F(LedgerStartTest, AnOldCopyGivesNoNumberTwice) {
  start();
  fs::copy_file(path(), folder_ / "copy");
  std::int64_t last = 0;
  for (int i = 0; i < 3; ++i) {
    QueueThread ledger(find_ledger(folder_.path(), {}, false), [](const std::function<void()>& task) { task(); });
    ledger.run_now([&](JobQueue& queue) {
      JobSubmission submission;
      submission.type = "drill";
      for (int j = 0; j < 200; ++j) last = queue.submit(submission, nullptr, 1).id;
    });
  }
  EXPECT_EQ(last, 601);
  for (const char* part : {"-wal", "-shm"}) fs::remove(path() + part);
  fs::rename(folder_ / "copy", path());
  EXPECT_EQ(start(), 769);
}

// Otherwise a new job would show the log of an old job.
TEST_F(LedgerStartTest, NumbersGoOnAboveAllThatLiesThere) {
  start();
  const std::string before = instance_;
  testing::write_bytes(folder_ / "logs/341.log", "of another job");
  fs::remove(path());
  EXPECT_EQ(start(true), 342);
  EXPECT_EQ(instance_, before) << "the old ledger may come back";
  testing::write_bytes(folder_ / "logs/360.log", "of a job after the backup that this ledger is");
  EXPECT_EQ(start(), 361);
}

TEST_F(LedgerStartTest, ALedgerOfBeforeTakesTheFoldersName) {
  start();
  {
    JobQueue queue(find_ledger(folder_.path(), {}, false));
    queue.database().execute(
        "DROP TABLE slurm_parts; DROP TABLE meta; DROP TABLE left_overs; DROP TABLE uploads; PRAGMA application_id = "
        "0; "
        "PRAGMA user_version = "
        "3");
  }
  const std::string before = instance_;
  EXPECT_EQ(start(), 2);
  EXPECT_EQ(instance_, before);
}

}  // namespace
}  // namespace multum
