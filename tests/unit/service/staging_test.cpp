// SPDX-License-Identifier: Apache-2.0
// Results get their names, over what may be replaced, and over nothing else.
#include "host/service/files/staging.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "host/base/error.h"
#include "host/base/files/atomic_file.h"
#include "host/service/files/data_lock.h"
#include "host/service/files/result_listing.h"
#include "tests/unit/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

class StagingTest : public ::testing::Test {
 protected:
  StagingTest() { fs::create_directory(root_); }
  StagedResult staged(std::int64_t id) const { return {roots_, output_, "0123abcd", id}; }
  // A folder of results, made for this job; returns its identity.
  std::string make_folder_of(std::int64_t id, const std::vector<std::string>& names) const {
    const std::string made = make_staging(id);
    for (const std::string& name : names) {
      fs::create_directories(fs::path(made + "/" + name).parent_path());
      write_text_file(made + "/" + name, name + std::to_string(id));
    }
    return staged(id).identity();
  }
  /// Path of the result in its staging folder, which is there then.
  std::string make_staging(std::int64_t id) const {
    open_staging_folder(roots_, staging_folder(output_, "0123abcd", id));
    return staged_path(output_, "0123abcd", id);
  }
  std::set<std::string> names(const std::string& folder) const {
    std::set<std::string> found;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder))
      if (entry.is_regular_file()) found.insert(entry.path().lexically_relative(folder).string());
    found.erase(".multum-result");
    return found;
  }
  void refused(std::int64_t id, const std::string& identity, const std::string& word) const {
    for (const bool is_publishing : {false, true}) {
      try {
        if (is_publishing) staged(id).publish(identity);
        else staged(id).check_place(true);
        ADD_FAILURE() << "not refused";
      } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::kUsage);
        testing::expect_says(error.what(), {output_, word});
      }
    }
  }

  TemporaryFolder folder_;
  const std::string root_ = fs::canonical(folder_ / "").string() + "/root";
  const std::string output_ = root_ + "/result";
  const PathRoots roots_ = [this] {
    fs::create_directory(root_);
    return PathRoots({root_});
  }();
};

TEST_F(StagingTest, AFolderTakesThePlaceOfAnEarlierResultWhole) {
  staged(1).publish(make_folder_of(1, {"a", "sub/b"}));
  EXPECT_EQ(names(output_), (std::set<std::string>{"a", "sub/b"}));
  EXPECT_EQ(staged(2).publish(make_folder_of(2, {"a", "c"})), "");
  EXPECT_EQ(names(output_), (std::set<std::string>{"a", "c"}));
  EXPECT_EQ(std::distance(fs::directory_iterator(root_), {}), 1) << "something is left beside it";
}

TEST_F(StagingTest, TemporaryFilesThatWereLeftAreNoResults) {
  EXPECT_EQ(staged(1).publish(make_folder_of(1, {"a", "sub/.multum-tmp-4711-3-b.exr", "sub/b.exr"})), "");
  EXPECT_EQ(names(output_), (std::set<std::string>{"a", "sub/b.exr"}));
  EXPECT_TRUE(is_as_made(output_, file_identity(output_)));
}

TEST_F(StagingTest, AnEmptyFolderIsRoom) {
  fs::create_directories(output_ + "/empty/below");
  staged(1).publish(make_folder_of(1, {"a"}));
  EXPECT_EQ(names(output_), std::set<std::string>{"a"});
}

TEST_F(StagingTest, AFolderOfTheUserStays) {
  fs::create_directory(output_);
  write_text_file(output_ + "/mine.txt", "weeks of work");
  refused(1, make_folder_of(1, {"a"}), "mine.txt");
  EXPECT_EQ(names(output_), std::set<std::string>{"mine.txt"});
}

TEST_F(StagingTest, WhatWasAddedToAResultOrChangedStays) {
  staged(1).publish(make_folder_of(1, {"a", "b"}));
  write_text_file(output_ + "/mine.txt", "added");
  refused(2, make_folder_of(2, {"a"}), "mine.txt");
  fs::remove(output_ + "/mine.txt");
  std::ofstream(output_ + "/b", std::ios::app) << " changed";
  refused(2, staged(2).identity(), "b");
  fs::remove(output_ + "/b");
  fs::create_symlink("/etc", output_ + "/b");
  refused(2, staged(2).identity(), "b");
  fs::remove(output_ + "/b");
  staged(2).publish(staged(2).identity());
  EXPECT_EQ(names(output_), std::set<std::string>{"a"});
}

TEST_F(StagingTest, FilesAndFoldersAreNotMixedUp) {
  write_text_file(output_, "a file");
  refused(1, make_folder_of(1, {"a"}), "file");
  fs::remove(output_);
  fs::create_directory(output_);
  const std::string made = make_staging(2);
  write_text_file(made, "a file");
  EXPECT_THROW(staged(2).check_place(false), Error);
  EXPECT_THROW(staged(2).publish(staged(2).identity()), Error);
  EXPECT_TRUE(fs::is_directory(output_));
}

// A daemon that died between the exchange and its note finds the folder before in the staging folder.
TEST_F(StagingTest, WhatCameInTheMeantimeIsPutAside) {
  staged(1).publish(make_folder_of(1, {"a", "b"}));
  const std::string identity = make_folder_of(2, {"a"});
  const std::string made = staged_path(output_, "0123abcd", 2);
  fs::rename(output_, output_ + ".old");
  fs::rename(made, output_);
  fs::rename(output_ + ".old", made);
  write_text_file(made + "/late.txt", "late");
  const std::string kept = staged(2).publish(identity);
  EXPECT_EQ(names(output_), std::set<std::string>{"a"});
  EXPECT_EQ(names(kept), std::set<std::string>{"late.txt"});
  EXPECT_FALSE(fs::exists(staging_folder(output_, "0123abcd", 2)));
}

TEST_F(StagingTest, WhatIsPutAsideTakesNobodysName) {
  staged(1).publish(make_folder_of(1, {"a"}));
  for (const char* taken : {".kept-2", ".kept-2-2"}) write_text_file(output_ + taken, "somebody's");
  const std::string identity = make_folder_of(2, {"a"}), made = staged_path(output_, "0123abcd", 2);
  fs::rename(output_, output_ + ".old");
  fs::rename(made, output_);
  fs::rename(output_ + ".old", made);
  write_text_file(made + "/late.txt", "late");
  EXPECT_EQ(staged(2).publish(identity), output_ + ".kept-2-3");
  EXPECT_TRUE(fs::is_regular_file(output_ + ".kept-2")) << "replaced";
}

// Else the next attempt would go on from what is the user's.
TEST_F(StagingTest, WhatCannotBePutAsideGoesBack) {
  staged(1).publish(make_folder_of(1, {"a"}));
  for (int i = 1; i <= 100; ++i) write_text_file(output_ + ".kept-2" + (i == 1 ? "" : "-" + std::to_string(i)), "");
  const std::string identity = make_folder_of(2, {"b"}), made = staged_path(output_, "0123abcd", 2);
  fs::rename(output_, output_ + ".old");
  fs::rename(made, output_);
  fs::rename(output_ + ".old", made);
  write_text_file(made + "/late.txt", "late");
  EXPECT_THROW(staged(2).publish(identity), Error);
  EXPECT_TRUE(names(output_).contains("late.txt"));
  EXPECT_EQ(names(made), std::set<std::string>{"b"});
  EXPECT_EQ(staged(2).identity(), identity);
}

TEST_F(StagingTest, AResultIsAsMadeWithAllThatItHeldAndNoMore) {
  const auto is_intact = [&](const std::string& identity) { return is_as_made(output_, identity); };
  const std::string identity = make_folder_of(1, {"a", "sub/b"});
  staged(1).publish(identity);
  EXPECT_TRUE(is_intact(identity));
  EXPECT_FALSE(is_intact("")) << "of a job that published nothing";
  write_text_file(output_ + "/sub/more", "");
  EXPECT_FALSE(is_intact(identity));
  fs::remove(output_ + "/sub/more");
  EXPECT_TRUE(is_intact(identity));
  fs::remove(output_ + "/a");
  EXPECT_FALSE(is_intact(identity));
  fs::remove_all(output_);
  EXPECT_FALSE(is_intact(identity));
  EXPECT_FALSE(is_as_made(output_, "")) << "nothing is no result";
}

// While it is removed, a folder in it becomes a link to the user's: again and again, by a thread of its own.
TEST_F(StagingTest, ALinkThatComesWhileAResultIsRemovedLeadsNowhere) {
  const std::string mine = folder_ / "mine", sub = output_ + "/sub", aside = root_ + "/aside";
  std::set<std::string> all;
  for (int i = 0; i < 50; ++i) all.insert(std::to_string(i));
  const auto fill = [&](const std::string& folder) {
    fs::create_directories(folder);
    for (const std::string& name : all) std::ofstream(folder + "/" + name) << "text";
  };
  fill(mine);
  for (int i = 0; i < 50; ++i) {
    fill(sub);
    write_result_listing(output_);
    std::atomic<int> swaps = 0;
    std::atomic<bool> is_over = false;
    std::thread swapper([&] {
      std::error_code ignored;
      while (!is_over) {
        fs::rename(sub, aside, ignored);
        if (ignored) continue;
        fs::create_directory_symlink(mine, sub, ignored);
        fs::remove(sub, ignored);
        fs::rename(aside, sub, ignored);
        ++swaps;
      }
    });
    while (swaps == 0) std::this_thread::yield();  // on a busy machine it may begin when all is over
    EXPECT_NO_THROW(remove_listed(output_));
    is_over = true;
    swapper.join();
    for (const std::string& left : {aside, output_}) fs::remove_all(left);
  }
  EXPECT_EQ(names(mine), all);
}

TEST_F(StagingTest, ALinkIsNoResult) {
  const std::string made = make_staging(1);
  fs::create_symlink("/etc/passwd", made);
  EXPECT_EQ(staged(1).identity(), "");
}

// Who may write to the folder of results knows the next staging folder's name.
TEST_F(StagingTest, WhatSomebodyPutInAStagingFoldersPlaceIsLeftAlone) {
  const std::string mine = root_ + "/mine", staging = staging_folder(output_, "0123abcd", 1);
  const auto expect_left_alone = [&](const std::string& word) {
    testing::expect_error(ErrorCode::kEnvironment, {staging, word}, [&] { open_staging_folder(roots_, staging); });
    EXPECT_THROW(staged(1).remove(), Error);
    EXPECT_THROW(staged(1).identity(), Error);
    EXPECT_TRUE(sweep_staging(roots_, {root_}, "0123abcd", [](std::int64_t) { return true; }).empty());
  };
  fs::create_directory(mine);
  write_text_file(mine + "/thesis.txt", "weeks of work");
  fs::create_directory_symlink(mine, staging);
  expect_left_alone("is a symbolic link");
  EXPECT_EQ(testing::read_bytes(mine + "/thesis.txt"), "weeks of work");
  fs::remove(staging);
  fs::rename(mine, staging);  // the daemon's own, by a rename
  expect_left_alone("did not make it");
  fs::permissions(staging, fs::perms(0777));
  expect_left_alone("others may write");
  EXPECT_EQ(testing::read_bytes(staging + "/thesis.txt"), "weeks of work");
}

TEST_F(StagingTest, DataIsForTheDaemonAlone) {
  const std::string data = folder_ / "data";
  ASSERT_NE(DataLock::take(data), nullptr);
  EXPECT_EQ(fs::status(data).permissions(), fs::perms::owner_all);
  fs::permissions(data, fs::perms(0777));
  testing::expect_error(ErrorCode::kEnvironment, {data, "0777", "others may write"}, [&] { DataLock::take(data); });
  fs::permissions(data, fs::perms(0755));
  fs::create_directory_symlink(data, folder_ / "link");
  EXPECT_NE(DataLock::take(folder_ / "link"), nullptr) << "a link of one's own";
  fs::create_directory_symlink(folder_ / "nowhere", folder_ / "dangling");
  testing::expect_error(ErrorCode::kEnvironment, {"dangling", "leads nowhere"},
                        [&] { DataLock::take(folder_ / "dangling"); });
  if (geteuid() != 0) return;
  ASSERT_EQ(lchown((folder_ / "link").c_str(), 65534, 65534), 0);
  testing::expect_error(ErrorCode::kEnvironment, {"link that user 65534 made"},
                        [&] { DataLock::take(folder_ / "link"); });
  ASSERT_EQ(chown(data.c_str(), 65534, 65534), 0);
  testing::expect_error(ErrorCode::kEnvironment, {data, "belongs to user 65534"}, [&] { DataLock::take(data); });
}

TEST_F(StagingTest, SweepsItsOwnAlone) {
  make_folder_of(1, {"a"});
  make_folder_of(2, {"a"});
  fs::create_directory(root_ + "/.multum-another-1");
  fs::create_directory(root_ + "/.multum-0123abcd-x");
  EXPECT_EQ(sweep_staging(roots_, {root_ + "/", root_ + "/gone/", "/etc/"}, "0123abcd",
                          [](std::int64_t id) { return id != 2; })
                .size(),
            1u);
  EXPECT_FALSE(fs::exists(staging_folder(output_, "0123abcd", 1)));
  EXPECT_TRUE(fs::exists(staging_folder(output_, "0123abcd", 2)));
  EXPECT_TRUE(fs::exists(root_ + "/.multum-another-1"));
  EXPECT_TRUE(fs::exists(root_ + "/.multum-0123abcd-x"));
}

}  // namespace
}  // namespace multum
