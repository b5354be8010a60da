// SPDX-License-Identifier: Apache-2.0
// Tests the files that the daemon stores for its clients: their total size, and the removal of files that nobody uses.
#include "host/farm/service/dispatch/data_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>
#include <memory>

#include "host/farm/service/files/job_numbers.h"
#include "host/farm/service/files/result_listing.h"
#include "host/farm/service/files/staging.h"
#include "host/farm/service/http/http_reply.h"
#include "host/foundation/base/files/atomic_file.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using std::chrono::hours;
using testing::TemporaryFolder;

void make_old(const std::string& path) {
  fs::last_write_time(path, fs::file_time_type::clock::now() - hours(100));
  fs::last_write_time(fs::path(path).parent_path(), fs::file_time_type::clock::now() - hours(100));
}

DataFolder::Upload store(DataFolder& data, const std::string& name, const std::string& bytes) {
  const std::shared_ptr<UploadFile> file = data.begin_upload(static_cast<std::int64_t>(bytes.size()));
  file->write(bytes);
  return data.store(name, *file);
}

LedgerSettings settings_in(const std::string& data, const std::string& name) {
  LedgerSettings settings;
  settings.path = data + "/" + name;
  settings.results = data + "/d/results";
  return settings;
}

class DataFolderTest : public ::testing::Test {
 protected:
  void sweep(DataFolder& data) {
    std::promise<void> done;
    data.sweep(*ledger_, hours(24), [&] { done.set_value(); });
    done.get_future().wait();
  }
  // Posted work runs on the thread of the ledger.
  std::unique_ptr<QueueThread> open(const std::string& name) {
    return std::make_unique<QueueThread>(settings_in(fs::canonical(folder_.path()).string(), name),
                                         [](const std::function<void()>& task) { task(); });
  }
  std::string made(const std::string& name) {
    const std::string path = folder_ / "d/" + name;
    fs::create_directories(fs::path(path).parent_path());
    write_text_file(path, name);
    make_old(path);
    return fs::canonical(path).string();
  }
  // A job with an output has published the output file.
  std::int64_t job(const std::string& output, const std::string& input = "") {
    std::int64_t id = 0;
    ledger_->run_now([&](JobQueue& queue) {
      JobSubmission submission;
      submission.type = "bake";
      submission.parameters = "{\"input\":\"" + input + "\"}";
      submission.output = output;
      id = queue.submit(submission, nullptr, 1).id;
      if (output.empty()) return;
      const ClaimLimits limits = {{{"default", {}}}, {}, 0};
      queue.begin_publishing(id, "a", queue.claim(limits, "a", 1)->attempt, file_identity(output));
      queue.published(id, 2);
    });
    return id;
  }
  void purge(std::int64_t id) {
    ledger_->run_now([&](JobQueue& queue) {
      queue.cancel(id, "", 2);
      EXPECT_EQ(queue.purge({id}).size(), 1u);
    });
  }

  TemporaryFolder folder_;
  std::unique_ptr<QueueThread> ledger_ = open("jobs.sqlite");
};

TEST_F(DataFolderTest, UploadsAreKeptByTheirContent) {
  DataFolder data(folder_ / "d", 0);
  const DataFolder::Upload one = store(data, "a.png", "content"), same = store(data, "a.png", "content"),
                           other = store(data, "b.png", "content"), changed = store(data, "a.png", "changed");
  EXPECT_EQ(one.path, same.path);
  EXPECT_NE(one.path, other.path);
  EXPECT_NE(one.path, changed.path);
  EXPECT_EQ(one.sha256, other.sha256);
  EXPECT_EQ(fs::file_size(one.path), 7u);
}

TEST_F(DataFolderTest, IsHeldToItsLimit) {
  DataFolder data(folder_ / "d", 1000);
  store(data, "a.png", std::string(600, 'a'));
  try {
    store(data, "b.png", std::string(401, 'b'));
    FAIL() << "an upload above the limit was accepted";
  } catch (const Refusal& refusal) {
    EXPECT_EQ(refusal.status, 507);
    testing::expect_says(refusal.message, {"600", "1000", "401"});
  }
  EXPECT_FALSE(fs::exists(data.uploads() + "/b.png"));
  // An upload that never arrives is not counted.
  data.begin_upload(400);
  const std::shared_ptr<UploadFile> coming = data.begin_upload(200);
  EXPECT_THROW(data.begin_upload(201), Refusal) << "both uploads together exceed the limit";
  store(data, "c.png", std::string(200, 'c'));
  coming->write(std::string(200, 'd'));
  data.store("d.png", *coming);
  EXPECT_THROW(data.check_room(1), Refusal);
  data.check_room(0);
}

TEST_F(DataFolderTest, WhatItsLedgerIsFinishedWithGoesAndNothingElse) {
  DataFolder data(folder_ / "d", 1 << 20);
  const std::string kept = made("results/kept.exr"), purged = made("results/purged.exr"),
                    below = made("results/sub/purged.exr"), shared = made("results/shared.exr"),
                    input = made("results/input.exr"), added = made("results/scene2/b.exr"),
                    foreign = made("results/foreign.exr"), foreign_below = made("results/sub/foreign.exr"),
                    folder = made("results/scene/a.exr"), other_log = made("logs/77.log"),
                    elsewhere = made("elsewhere.exr");
  write_result_listing(fs::path(folder).parent_path().string(), data.seal());
  write_result_listing(fs::path(added).parent_path().string(), data.seal());
  made("results/scene2/by_hand.txt");
  std::vector<std::int64_t> gone;
  job(kept);
  for (const std::string& output : {purged, below, shared, input, fs::path(folder).parent_path().string(),
                                    fs::path(added).parent_path().string(), elsewhere})
    gone.push_back(job(output));
  job(shared);
  job("", input);
  for (const std::int64_t id : gone) {
    made("logs/" + std::to_string(id) + ".log");
    purge(id);
  }
  sweep(data);
  for (const std::string& path : {kept, shared, input, added, foreign, foreign_below, other_log, elsewhere})
    EXPECT_TRUE(fs::exists(path)) << path;
  for (const std::string& path : {purged, below, fs::path(folder).parent_path().string()})
    EXPECT_FALSE(fs::exists(path)) << path;
  for (const std::int64_t id : gone) EXPECT_FALSE(fs::exists(folder_ / ("d/logs/" + std::to_string(id) + ".log")));
  // The file that now has this name is not the file that the job published.
  made("results/purged.exr");
  sweep(data);
  EXPECT_TRUE(fs::exists(purged));
  // The other job that uses this file is also purged.
  purge(gone.back() + 1);
  sweep(data);
  EXPECT_FALSE(fs::exists(shared));
}

TEST_F(DataFolderTest, AResultThatWasChangedSinceStays) {
  DataFolder data(folder_ / "d", 1 << 20);
  const std::string same = made("results/same.exr"), changed = made("results/changed.exr");
  for (const std::string& output : {same, changed}) job(output);
  write_text_file(changed, "by somebody else");
  ledger_->run_now([](JobQueue& queue) { EXPECT_EQ(queue.purge({1, 2}).size(), 2u); });
  // A job that never published a result does not own the file either.
  const std::string nobodys = made("results/nobodys.exr");
  ledger_->run_now([&](JobQueue& queue) {
    JobSubmission submission;
    submission.type = "bake";
    submission.output = nobodys;
    const std::int64_t id = queue.submit(submission, nullptr, 1).id;
    queue.cancel(id, "", 2);
    EXPECT_EQ(queue.purge({id}).size(), 1u);
  });
  sweep(data);
  EXPECT_FALSE(fs::exists(same));
  EXPECT_TRUE(fs::exists(changed));
  EXPECT_TRUE(fs::exists(nobodys));
}

TEST_F(DataFolderTest, UnderANewLedgerNothingIsRemoved) {
  DataFolder data(folder_ / "d", 1 << 20);
  const std::string result = made("results/a.exr"), below = made("results/sub/b.exr"), log = made("logs/1.log"),
                    upload = store(data, "a.png", "1").path;
  make_old(upload);
  ledger_->run_now([&](JobQueue& queue) { queue.files().note_upload(upload); });
  job(result);
  purge(job(below));
  ledger_ = open("new.sqlite");
  for (int i = 0; i < 3; ++i) job("");
  purge(2);
  sweep(data);
  for (const std::string& path : {result, below, log, upload}) EXPECT_TRUE(fs::exists(path)) << path;
}

TEST_F(DataFolderTest, OldUploadsThatWereNotedGo) {
  DataFolder data(folder_ / "d", 1 << 20);
  const std::string used = store(data, "used.png", "1").path, unused = store(data, "unused.png", "2").path,
                    young = store(data, "young.png", "3").path, unknown = store(data, "unknown.png", "4").path;
  for (const std::string& path : {used, unused, unknown}) make_old(path);
  ledger_->run_now([&](JobQueue& queue) {
    for (const std::string& path : {used, unused, young}) queue.files().note_upload(path);
  });
  const std::int64_t id = job("", used);
  sweep(data);
  EXPECT_TRUE(fs::exists(used));
  EXPECT_FALSE(fs::exists(unused));
  EXPECT_FALSE(fs::exists(fs::path(unused).parent_path()));
  EXPECT_TRUE(fs::exists(young));
  EXPECT_TRUE(fs::exists(unknown)) << "the ledger does not know the owner";
  purge(id);
  sweep(data);
  EXPECT_FALSE(fs::exists(used));
}

// If a symbolic link has replaced a result folder, the cleanup does not follow the link.
TEST_F(DataFolderTest, LinksAreNotFollowed) {
  DataFolder data(folder_ / "d", 1 << 20);
  const std::string result = made("results/sub/a.exr");
  purge(job(result));
  fs::create_directories(folder_ / "mine");
  write_text_file(folder_ / "mine/a.exr", "mine");
  fs::remove_all(folder_ / "d/results/sub");
  fs::create_directory_symlink(folder_ / "mine", folder_ / "d/results/sub");
  sweep(data);
  EXPECT_TRUE(fs::exists(folder_ / "mine/a.exr"));
}

TEST_F(DataFolderTest, ManyAreSweptInTurns) {
  DataFolder data(folder_ / "d", 1 << 20);
  ledger_->run_now([&](JobQueue& queue) {
    std::vector<std::int64_t> ids;
    for (int i = 0; i < 450; ++i) {
      JobSubmission submission;
      submission.type = "drill";
      ids.push_back(queue.submit(submission, nullptr, 1).id);
      queue.cancel(ids.back(), "", 1);
      queue.files().note_upload(folder_ / "gone/" + std::to_string(i));
    }
    queue.purge(ids);
  });
  made("logs/450.log");
  sweep(data);
  EXPECT_FALSE(fs::exists(folder_ / "d/logs/450.log"));
  ledger_->run_now([](JobQueue& queue) {
    EXPECT_TRUE(queue.files().left_overs(0, 10).empty());
    EXPECT_TRUE(queue.files().uploads("", 10).empty());
  });
}

TEST_F(DataFolderTest, KnowsTheHighestNumberInUse) {
  const DataFolder made_here(folder_ / "d", 0);
  const std::string data = folder_ / "d";
  EXPECT_EQ(highest_job_number(data), 0);
  made("logs/12.log");
  EXPECT_EQ(highest_job_number(data), 12);
  made("pictures/30-77-8-9/render.png");
  EXPECT_EQ(highest_job_number(data), 30);
  made("results/sub/.multum-01234567-41/a.exr");
  EXPECT_EQ(highest_job_number(data), 41);
  made("logs/99x.log");
  made("logs/99999999999999999.log");
  made("logs/999999999999999999999999.log");
  made("results/99.exr");
  EXPECT_EQ(highest_job_number(data), 41);
}

}  // namespace
}  // namespace multum
