// SPDX-License-Identifier: Apache-2.0
// Tests that results are renamed to their final names and replace only files that they may replace.
#include "host/farm/service/files/staging.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "host/farm/service/files/data_lock.h"
#include "host/farm/service/files/result_copy.h"
#include "host/farm/service/files/result_listing.h"
#include "host/foundation/base/error.h"
#include "host/foundation/base/files/atomic_file.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

class StagingTest : public ::testing::Test {
 protected:
  StagingTest() { fs::create_directory(root_); }
  StagedResult staged(std::int64_t id) const { return {roots_, output_, "0123abcd", id, seal_}; }
  // Makes a result folder for this job, and returns the identity of the folder.
  std::string make_folder_of(std::int64_t id, const std::vector<std::string>& names) const {
    const std::string made = make_staging(id);
    for (const std::string& name : names) {
      fs::create_directories(fs::path(made + "/" + name).parent_path());
      write_text_file(made + "/" + name, name + std::to_string(id));
    }
    return staged(id).identity();
  }
  /// Creates the staging folder of the result, and returns the path of the result in it.
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
  const ResultSeal seal_ = {"a key"};
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
  EXPECT_EQ(std::distance(fs::directory_iterator(root_), {}), 1) << "something is left next to the result";
}

TEST_F(StagingTest, TemporaryFilesThatWereLeftAreNoResults) {
  EXPECT_EQ(staged(1).publish(make_folder_of(1, {"a", "sub/.multum-tmp-4711-3-b.exr", "sub/b.exr"})), "");
  EXPECT_EQ(names(output_), (std::set<std::string>{"a", "sub/b.exr"}));
  EXPECT_TRUE(is_as_made(roots_, output_, file_identity(output_), seal_));
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

// If a daemon died after it exchanged the folders but before it recorded this, the next daemon finds the earlier folder
// in the staging folder.
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

// Otherwise the next attempt would continue from the user's files.
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
  const auto is_intact = [&](const std::string& identity) { return is_as_made(roots_, output_, identity, seal_); };
  const std::string identity = make_folder_of(1, {"a", "sub/b"});
  staged(1).publish(identity);
  EXPECT_TRUE(is_intact(identity));
  EXPECT_FALSE(is_intact("")) << "the job published nothing";
  write_text_file(output_ + "/sub/more", "");
  EXPECT_FALSE(is_intact(identity));
  fs::remove(output_ + "/sub/more");
  EXPECT_TRUE(is_intact(identity));
  fs::remove(output_ + "/a");
  EXPECT_FALSE(is_intact(identity));
  fs::remove_all(output_);
  EXPECT_FALSE(is_intact(identity));
  EXPECT_FALSE(is_as_made(roots_, output_, "", seal_)) << "a missing file is not a result";
}

// While a result is being removed, another thread repeatedly replaces one of its folders by a link to a folder of the
// user.
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
    write_result_listing(output_, seal_);
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
    while (swaps == 0) std::this_thread::yield();  // on a busy machine, the thread may start too late
    EXPECT_NO_THROW(remove_listed(output_, seal_));
    is_over = true;
    swapper.join();
    for (const std::string& left : {aside, output_}) fs::remove_all(left);
  }
  EXPECT_EQ(names(mine), all);
}

// The result was moved away, and a link to it has replaced it. No file may be read or written through that name.
TEST_F(StagingTest, AResultBehindALinkIsNotAsMade) {
  const std::string identity = make_folder_of(1, {"a"});
  staged(1).publish(identity);
  fs::rename(output_, root_ + "/moved");
  fs::create_directory_symlink(root_ + "/moved", output_);
  EXPECT_EQ(result_identity(roots_, output_), "");
  EXPECT_FALSE(is_as_made(roots_, output_, identity, seal_));
  EXPECT_TRUE(is_as_made(roots_, root_ + "/moved", identity, seal_));
  // Here, the result is a file.
  const std::string file = root_ + "/file.exr", moved = root_ + "/moved.exr";
  write_text_file(file, "pixels");
  const std::string of_file = result_identity(roots_, file);
  EXPECT_TRUE(is_as_made(roots_, file, of_file, seal_));
  fs::rename(file, moved);
  fs::create_symlink(moved, file);
  EXPECT_FALSE(is_as_made(roots_, file, of_file, seal_));
  // Here, a folder above the result is a link.
  fs::create_directory(root_ + "/above");
  fs::rename(moved, root_ + "/above/file.exr");
  fs::rename(root_ + "/above", root_ + "/elsewhere");
  fs::create_directory_symlink(root_ + "/elsewhere", root_ + "/above");
  EXPECT_FALSE(is_as_made(roots_, root_ + "/above/file.exr", of_file, seal_));
}

TEST_F(StagingTest, CopiesAreOfFilesAndFoldersAlone) {
  const std::string mine = folder_ / "mine.txt";
  write_text_file(mine, "mine");
  staged(1).publish(make_folder_of(1, {"a", "sub/b"}));
  fs::create_directory(root_ + "/to");
  copy_result(roots_, output_, root_ + "/to/copy");
  EXPECT_EQ(names(root_ + "/to/copy"), (std::set<std::string>{"a", "sub/b"}));
  EXPECT_FALSE(fs::exists(root_ + "/to/copy/.multum-result")) << "the copy gets its own listing";
  copy_result(roots_, output_ + "/a", root_ + "/to/a");
  EXPECT_EQ(testing::read_bytes(root_ + "/to/a"), "a1");
  // The remains of an earlier attempt are replaced. If a link has replaced them, it is not followed.
  fs::remove(root_ + "/to/a");
  fs::create_symlink(mine, root_ + "/to/a");
  copy_result(roots_, output_ + "/a", root_ + "/to/a");
  EXPECT_FALSE(fs::is_symlink(root_ + "/to/a"));
  EXPECT_EQ(testing::read_bytes(mine), "mine");
  for (const std::string& made : {root_ + "/link", output_ + "/sub/link"}) {
    fs::create_symlink(mine, made);
    EXPECT_THROW(copy_result(roots_, made.find("sub") == std::string::npos ? made : output_, root_ + "/to/c"), Error);
    fs::remove(made);
  }
}

// Anybody who can write to a folder can forge a listing in it: with the files of a user, with an extra line, or with
// the files of another folder.
TEST_F(StagingTest, AForgedListingIsNone) {
  fs::create_directory(output_);
  write_text_file(output_ + "/mine.txt", "weeks of work");
  write_result_listing(output_, {});  // without a seal
  refused(1, make_folder_of(1, {"a"}), "mine.txt");
  write_result_listing(output_, {"another key"});
  refused(1, staged(1).identity(), "mine.txt");
  EXPECT_EQ(names(output_), std::set<std::string>{"mine.txt"});
  fs::remove_all(output_);
  staged(1).publish(staged(1).identity());
  EXPECT_EQ(unlisted_in(output_, seal_), "");
  // The listing has an extra line.
  const std::string listing = output_ + "/.multum-result", whole = testing::read_bytes(listing);
  write_text_file(output_ + "/mine.txt", "added");
  const std::string own =
      "5 " + file_identity(output_ + "/mine.txt").substr(file_identity(output_ + "/mine.txt").rfind(':') + 1);
  for (const std::string& text : {own + " mine.txt\n" + whole, whole + own + " mine.txt\n",
                                  whole.substr(0, whole.rfind("seal ")) + own + " mine.txt\n"}) {
    testing::write_bytes(listing, text);
    EXPECT_NE(unlisted_in(output_, seal_), "") << text;
    EXPECT_FALSE(remove_listed(output_, seal_));
    EXPECT_TRUE(fs::exists(output_ + "/mine.txt"));
  }
  // This listing belongs to another folder with the same files.
  fs::remove(output_ + "/mine.txt");
  testing::write_bytes(listing, whole);
  EXPECT_TRUE(is_as_published(output_, seal_));
  fs::copy(output_, root_ + "/other", fs::copy_options::recursive);
  fs::last_write_time(root_ + "/other/a", fs::last_write_time(output_ + "/a"));
  EXPECT_FALSE(is_as_published(root_ + "/other", seal_));
  EXPECT_EQ(unlisted_in(root_ + "/other", {}), "") << "only the seal differs";
}

TEST_F(StagingTest, TheKeyIsMadeOnceAndItsOwnersAlone) {
  const std::string path = folder_ / "seal";
  const ResultSeal first = take_up_seal(path);
  EXPECT_EQ(first.key.size(), 64u);
  EXPECT_EQ(take_up_seal(path).key, first.key);
  EXPECT_EQ(fs::status(path).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  testing::write_bytes(path, "cut");
  EXPECT_NE(take_up_seal(path).key, first.key);
}

TEST_F(StagingTest, ALinkIsNoResult) {
  const std::string made = make_staging(1);
  fs::create_symlink("/etc/passwd", made);
  EXPECT_EQ(staged(1).identity(), "");
}

// Anybody who can write to the result folder can predict the name of the next staging folder.
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
  fs::rename(mine, staging);  // replaces the daemon's folder with a rename
  expect_left_alone("did not create it");
  fs::permissions(staging, fs::perms(0777));
  expect_left_alone("other users write");
  EXPECT_EQ(testing::read_bytes(staging + "/thesis.txt"), "weeks of work");
}

TEST_F(StagingTest, DataIsForTheDaemonAlone) {
  const std::string data = folder_ / "data";
  ASSERT_NE(DataLock::take(data), nullptr);
  EXPECT_EQ(fs::status(data).permissions(), fs::perms::owner_all);
  for (const auto& [mode, text] : {std::pair(0777, "0777"), {0770, "0770"}, {0702, "0702"}}) {
    fs::permissions(data, fs::perms(mode));
    testing::expect_error(ErrorCode::kEnvironment, {data, text, "other users write"}, [&] { DataLock::take(data); });
  }
  fs::permissions(data, fs::perms(0755));
  fs::create_directory_symlink(data, folder_ / "link");
  EXPECT_NE(DataLock::take(folder_ / "link"), nullptr) << "users may link to their own folders";
  fs::create_directory_symlink(folder_ / "nowhere", folder_ / "dangling");
  testing::expect_error(ErrorCode::kEnvironment, {"dangling", "missing file"},
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
