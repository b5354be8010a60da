// SPDX-License-Identifier: Apache-2.0
// Tests a ledger that is removed while it is in use. The daemon confirms only changes that are in the file at the
// ledger's path.
#include "host/farm/service/ledger/queue_thread.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "host/farm/service/files/no_space.h"
#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::expect_error;
using testing::TemporaryFolder;

LedgerSettings at(const std::string& path) {
  LedgerSettings settings;
  settings.path = path;
  return settings;
}

struct Loss {
  const char* name;
  std::function<void(const std::string& folder)> lose;
};

void PrintTo(const Loss& loss, std::ostream* out) { *out << loss.name; }

class LedgerLossTest : public ::testing::TestWithParam<Loss> {};

TEST_P(LedgerLossTest, IsNoticedBeforeAnythingIsAccepted) {
  const TemporaryFolder folder;
  fs::create_directory(folder / "data");
  const std::string path = folder / "data/jobs.sqlite";
  QueueThread ledger(at(path), [](const std::function<void()>& task) { task(); });
  const auto submit = [&] {
    ledger.run_now([](JobQueue& queue) {
      JobSubmission submission;
      submission.type = "drill";
      submission.key = "k";
      queue.submit(
          submission, [](const Job&) { return true; }, 1);
    });
  };
  submit();
  EXPECT_FALSE(ledger.is_lost());
  GetParam().lose(folder.path());
  for (int i = 0; i < 3; ++i) expect_error(ErrorCode::kEnvironment, {path, "lost", "restarted"}, submit);
  EXPECT_TRUE(ledger.is_lost());
  int found = 0;
  ledger.run_now([&](JobQueue& queue) { found = queue.find(1) ? 1 : 0; });
  EXPECT_EQ(found, 1) << "reading still works";
  expect_error(ErrorCode::kEnvironment, {"lost"},
               [&] { ledger.run_now([](JobQueue& queue) { queue.cancel(1, "by a test", 2); }); });
  expect_error(ErrorCode::kEnvironment, {"lost"}, [&] { ledger.run_now([](JobQueue& queue) { queue.check_kept(); }); });
}

// A limit on file sizes acts like a full disk. Work that does not fit is refused with that reason, and no part of it is
// kept. The write-ahead log is emptied, so the next work fits as long as the ledger itself has space.
TEST(LedgerSpaceTest, ALimitOfFileSizesIsNoSpaceAndNoEnd) {
  const TemporaryFolder folder;
  const std::string path = folder / "jobs.sqlite";
  QueueThread ledger(at(path), [](const std::function<void()>& task) { task(); });
  std::vector<std::int64_t> kept;
  int refused = 0, after_refusal = 0;
  const auto submit = [&] {
    ledger.run_now([&](JobQueue& queue) {
      JobSubmission submission;
      submission.parameters = "{\"text\":\"" + std::string(100000, 'x') + "\"}";
      kept.push_back(queue.submit(submission, nullptr, 1).id);
    });
  };
  {
    const testing::FileLimit limit(1 << 20);
    for (int i = 0; i < 30; ++i) {
      const std::size_t before = kept.size();
      try {
        submit();
        after_refusal += refused > 0 ? 1 : 0;
      } catch (const NoSpaceError& error) {
        testing::expect_says(error.what(), {path, "File too large"});
        kept.resize(before);
        ++refused;
      }
    }
    int found = 0;
    ledger.run_now([&](JobQueue& queue) { found = static_cast<int>(queue.list({}).size()); });
    EXPECT_EQ(found, static_cast<int>(kept.size())) << "reading still works, and refused jobs are absent";
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(after_refusal, 0) << "the log was never emptied";
  submit();
  EXPECT_FALSE(ledger.is_lost());
}

void copy_to(const std::string& from, const std::string& to) {
  fs::remove(to);
  fs::copy_file(from, to);
}

INSTANTIATE_TEST_SUITE_P(
    Ways, LedgerLossTest,
    ::testing::Values(
        Loss{"removed", [](const std::string& folder) { fs::remove(folder + "/data/jobs.sqlite"); }},
        Loss{"log_removed", [](const std::string& folder) { fs::remove(folder + "/data/jobs.sqlite-wal"); }},
        Loss{"renamed",
             [](const std::string& folder) { fs::rename(folder + "/data/jobs.sqlite", folder + "/data/old"); }},
        Loss{"replaced",
             [](const std::string& folder) {
               copy_to(folder + "/data/jobs.sqlite", folder + "/data/copy");
               fs::rename(folder + "/data/copy", folder + "/data/jobs.sqlite");
             }},
        Loss{"folder_renamed", [](const std::string& folder) { fs::rename(folder + "/data", folder + "/old"); }},
        Loss{"folder_removed", [](const std::string& folder) { fs::remove_all(folder + "/data"); }}),
    [](const auto& one) { return std::string(one.param.name); });

// Work that was confirmed earlier is in the remaining file.
TEST(QueueThread, ALogThatIsRemovedTakesNothingWithIt) {
  const TemporaryFolder folder;
  const std::string path = folder / "jobs.sqlite";
  {
    QueueThread ledger(at(path), [](const std::function<void()>& task) { task(); });
    for (int i = 0; i < 10; ++i)
      ledger.run_now([](JobQueue& queue) {
        JobSubmission submission;
        submission.type = "drill";
        queue.submit(submission, nullptr, 1);
      });
    fs::remove(path + "-wal");
    expect_error(ErrorCode::kEnvironment, {path + "-wal", "removed"},
                 [&] { ledger.run_now([](JobQueue& queue) { queue.cancel(1, "by a test", 2); }); });
  }
  JobQueue queue(at(path));
  EXPECT_EQ(queue.list({}).size(), 10u);
  EXPECT_EQ(queue.database().damage(), "");
}

// If the file disappears in the middle of a batch, the finished part of the batch is not committed.
TEST(QueueThread, ALossBetweenWorkAndCommitIsNoticed) {
  const TemporaryFolder folder;
  const std::string path = folder / "jobs.sqlite", kept = folder / "kept";
  {
    QueueThread ledger(at(path), [](const std::function<void()>& task) { task(); });
    expect_error(ErrorCode::kEnvironment, {"lost"}, [&] {
      ledger.run_now([&](JobQueue& queue) {
        JobSubmission submission;
        submission.type = "drill";
        queue.submit(submission, nullptr, 1);
        fs::rename(path, kept);
        fs::rename(path + "-wal", kept + "-wal");
      });
    });
  }
  JobQueue queue(at(kept));
  EXPECT_TRUE(queue.list({}).empty());
}

}  // namespace
}  // namespace multum
