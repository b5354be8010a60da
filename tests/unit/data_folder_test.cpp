// SPDX-License-Identifier: Apache-2.0
// What the daemon keeps for others: how much of it, and what goes when nobody has a use for it.
#include "host/service/data_folder.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <future>

#include "host/base/atomic_file.h"
#include "host/service/http_reply.h"
#include "tests/unit/test_folder.h"

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

class DataFolderTest : public ::testing::Test {
 protected:
  // Both threads are done when it returns.
  void sweep(DataFolder& data) {
    data.sweep(ledger_, hours(24));
    std::function<void()> done;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [&] { return !posted_.empty(); });
      done = std::move(posted_.back());
      posted_.clear();
    }
    done();  // hands it to the folder's thread
  }

  TemporaryFolder folder_;
  std::mutex mutex_;
  std::condition_variable wake_;
  std::vector<std::function<void()>> posted_;
  QueueThread ledger_{folder_ / "jobs.sqlite", RetryPolicy{}, [this](std::function<void()> task) {
                        const std::lock_guard lock(mutex_);
                        posted_.push_back(std::move(task));
                        wake_.notify_one();
                      }};
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
    FAIL() << "more than the limit is taken";
  } catch (const Refusal& refusal) {
    EXPECT_EQ(refusal.status, 507);
    testing::expect_says(refusal.message, {"600", "1000", "401"});
  }
  EXPECT_FALSE(fs::exists(data.uploads() + "/b.png"));
  // What does not come is not counted.
  data.begin_upload(400);
  const std::shared_ptr<UploadFile> coming = data.begin_upload(200);
  EXPECT_THROW(data.begin_upload(201), Refusal) << "both together are too many";
  store(data, "c.png", std::string(200, 'c'));
  coming->write(std::string(200, 'd'));
  data.store("d.png", *coming);
  EXPECT_THROW(data.check_room(1), Refusal);
  data.check_room(0);
}

TEST_F(DataFolderTest, WhatNobodyHasAUseForGoes) {
  std::string used, unused, young;
  std::int64_t kept = 0, purged = 0;
  {
    DataFolder data(folder_ / "d", 1 << 20);
    used = store(data, "used.png", "1").path;
    unused = store(data, "unused.png", "2").path;
    young = store(data, "young.png", "3").path;
    ledger_.run_now([&](JobQueue& queue) {
      JobSubmission submission;
      submission.type = "bake";
      submission.parameters = "{\"input\":\"" + used + "\"}";
      submission.output = fs::canonical(data.results()).string() + "/kept.ndf.exr";
      kept = queue.submit(submission, nullptr, 1).id;
      submission.parameters = "{\"input\":\"" + unused + "\"}";
      submission.output = fs::canonical(data.results()).string() + "/purged.ndf.exr";
      purged = queue.submit(submission, nullptr, 1).id;
      queue.cancel(purged, "", 2);
      queue.purge({purged});
    });
    for (const char* name : {"kept", "purged", "fresh"}) {
      write_text_file(data.results() + "/" + name + ".ndf.exr", name);
      if (std::string(name) != "fresh") make_old(data.results() + "/" + name + ".ndf.exr");
    }
    const std::string logs = folder_ / "d/logs/";
    for (const std::int64_t id : {kept, purged, std::int64_t{77}}) {
      write_text_file(logs + std::to_string(id) + ".log", "said");
      make_old(logs + std::to_string(id) + ".log");
    }
    make_old(used);
    make_old(unused);
    sweep(data);
  }  // waits for its thread
  EXPECT_TRUE(fs::exists(used));
  EXPECT_FALSE(fs::exists(unused));
  EXPECT_FALSE(fs::exists(fs::path(unused).parent_path()));
  EXPECT_TRUE(fs::exists(young));
  EXPECT_TRUE(fs::exists(folder_ / "d/results/kept.ndf.exr"));
  EXPECT_FALSE(fs::exists(folder_ / "d/results/purged.ndf.exr"));
  EXPECT_TRUE(fs::exists(folder_ / "d/results/fresh.ndf.exr"));
  EXPECT_TRUE(fs::exists(folder_ / ("d/logs/" + std::to_string(kept) + ".log")));
  EXPECT_FALSE(fs::exists(folder_ / ("d/logs/" + std::to_string(purged) + ".log")));
  EXPECT_TRUE(fs::exists(folder_ / "d/logs/77.log")) << "its job may be on its way into the ledger";
}

}  // namespace
}  // namespace multum
