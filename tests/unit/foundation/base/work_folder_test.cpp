// SPDX-License-Identifier: Apache-2.0
// Tests work folders next to outputs, where other users may write. Files that others put there are refused and not
// touched, and the message names them.
#include "host/foundation/base/files/work_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::expect_error;
using testing::Names;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

class WorkFolderTest : public ::testing::Test {
 protected:
  WorkFolderTest() {
    fs::create_directory(precious_);
    write_bytes(precious_ + "/thesis.txt", "weeks of work");
  }
  /// Every function that takes or removes the folder refuses or ignores the existing file, and the file does not
  /// change.
  void expect_left_alone(const std::string& word) const {
    const auto status = fs::symlink_status(partial_);
    expect_error(ErrorCode::kEnvironment, {partial_, word, "left unchanged"}, [&] { WorkFolder::take(partial_); });
    WorkFolder::drop(partial_);
    EXPECT_EQ(read_bytes(precious_ + "/thesis.txt"), "weeks of work");
    EXPECT_EQ(fs::symlink_status(partial_).type(), status.type());
  }

  TemporaryFolder folder_;
  const std::string partial_ = partial_folder_of(folder_ / "map.ndf.exr");
  const std::string precious_ = folder_ / "precious";
};

TEST_F(WorkFolderTest, IsForThisUserAloneAndGoesAtTheEnd) {
  {
    const auto work = WorkFolder::take(partial_);
    ASSERT_NE(work, nullptr);
    EXPECT_EQ(fs::status(partial_).permissions(), fs::perms::owner_all);
    fs::create_directories(work->path() + "/deep/deeper");
    write_bytes(work->path() + "/deep/deeper/rows", "x");
    EXPECT_TRUE(fs::exists(partial_ + "/deep/deeper/rows")) << "its path leads elsewhere";
    EXPECT_EQ(WorkFolder::take(partial_), nullptr) << "two owners have the folder at once";
    WorkFolder::drop(partial_);
    EXPECT_TRUE(fs::exists(partial_)) << "the folder was removed while its owner used it";
  }
  EXPECT_FALSE(fs::exists(partial_));
}

TEST_F(WorkFolderTest, WhatWasLeftIsThereAgain) {
  {
    const auto work = WorkFolder::take(partial_);
    write_bytes(work->path() + "/rows", "half");
    work->leave();
  }
  {
    const auto work = WorkFolder::take(partial_);
    EXPECT_EQ(read_bytes(work->path() + "/rows"), "half");
    write_bytes(work->path() + "/notes", "x");
    work->clear("notes");
    EXPECT_FALSE(fs::exists(work->path() + "/rows"));
    EXPECT_TRUE(fs::exists(work->path() + "/notes"));
    work->leave();
  }
  WorkFolder::drop(partial_);
  EXPECT_FALSE(fs::exists(partial_));
}

TEST_F(WorkFolderTest, ALinkIsNotFollowed) {
  fs::create_directory_symlink(precious_, partial_);
  expect_left_alone("is a symbolic link");
}

TEST_F(WorkFolderTest, ALinkThatLeadsNowhereIsNotFollowed) {
  fs::create_directory_symlink(folder_ / "not there", partial_);
  expect_left_alone("is a symbolic link");
}

TEST_F(WorkFolderTest, AFileAndAPipeAreNoFolders) {
  write_bytes(partial_, "x");
  expect_left_alone("is a file");
  fs::remove(partial_);
  ASSERT_EQ(mkfifo(partial_.c_str(), 0666), 0);
  expect_left_alone("is neither a file nor a folder");
}

// Anybody who can rename files in a shared folder can move another folder of ours there. That folder has the right
// owner and permissions.
TEST_F(WorkFolderTest, AnotherFolderOfThisUserIsNotEmptied) {
  fs::permissions(precious_, fs::perms::owner_all);
  fs::rename(precious_, partial_);
  expect_error(ErrorCode::kEnvironment, {partial_, "thesis.txt", "did not create it"},
               [&] { WorkFolder::take(partial_); });
  WorkFolder::drop(partial_);
  EXPECT_EQ(read_bytes(partial_ + "/thesis.txt"), "weeks of work");
}

TEST_F(WorkFolderTest, OneThatOthersMayWriteToIsRefused) {
  for (const auto mode : {fs::perms(0777), fs::perms(0770), fs::perms(01777)}) {
    fs::create_directory(partial_);
    fs::permissions(partial_, mode);
    expect_left_alone("other users write to it");
    fs::remove(partial_);
  }
}

TEST_F(WorkFolderTest, OneOfAnotherUserIsRefused) {
  if (geteuid() != 0) GTEST_SKIP() << "only root can make a folder that belongs to somebody else";
  fs::create_directory(partial_);
  ASSERT_EQ(chown(partial_.c_str(), 65534, 65534), 0);
  expect_left_alone("belongs to user 65534, but multum runs as user 0");
}

// A small ulimit -n has this effect.
TEST_F(WorkFolderTest, IsRemovedByAProcessThatMayOpenNoMoreFiles) {
  auto work = WorkFolder::take(partial_);
  for (const char* name : {"rows", "fits"}) write_bytes(work->path() + "/" + name, "x");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &none), 0);
  work.reset();
  setrlimit(RLIMIT_NOFILE, &before);
  EXPECT_FALSE(fs::exists(partial_));
}

TEST_F(WorkFolderTest, IsNotLeftByAProcessThatCannotOpenIt) {
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_NOFILE, &before), 0);
  const auto lowest = static_cast<rlim_t>(OpenFile(::dup(STDERR_FILENO)).descriptor());
  for (rlim_t more = 0; more < 3; ++more) {  // descriptors for the parent folder, the folder, its mark
    const rlimit few{lowest + more, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_NOFILE, &few), 0);
    try {
      WorkFolder::take(partial_);
      ADD_FAILURE() << "it was made with " << more << " descriptors";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kEnvironment) << error.what();
    }
    setrlimit(RLIMIT_NOFILE, &before);
    EXPECT_FALSE(fs::exists(partial_)) << more;
  }
}

TEST_F(WorkFolderTest, ErrorsHaveItsName) {
  const auto work = WorkFolder::take(partial_);
  const Error error(ErrorCode::kEnvironment, work->path() + "/rows: writing failed; see " + work->path());
  EXPECT_EQ(std::string(error.what()),
            fs::canonical(partial_).string() + "/rows: writing failed; see " + fs::canonical(partial_).string());
}

// Links in the folder are removed, and their targets stay.
TEST_F(WorkFolderTest, ClearingFollowsNoLink) {
  const auto work = WorkFolder::take(partial_);
  fs::create_directory_symlink(precious_, work->path() + "/link");
  fs::create_directory(work->path() + "/sub");
  fs::create_directory_symlink(precious_, work->path() + "/sub/link");
  work->clear();
  EXPECT_EQ(read_bytes(precious_ + "/thesis.txt"), "weeks of work");
  EXPECT_TRUE(fs::exists(partial_));
  EXPECT_FALSE(fs::exists(partial_ + "/sub"));
}

// If another folder gets the name during the work, the work continues in the opened folder, and no other folder is
// touched.
TEST_F(WorkFolderTest, ItsNameIsTrustedOnce) {
  {
    const auto work = WorkFolder::take(partial_);
    fs::rename(partial_, folder_ / "away");
    fs::create_directory_symlink(precious_, partial_);
    write_bytes(work->path() + "/thesis.txt", "rows");
    work->clear();
  }
  EXPECT_EQ(read_bytes(precious_ + "/thesis.txt"), "weeks of work");
  EXPECT_TRUE(fs::is_symlink(partial_));
}

TEST_F(WorkFolderTest, OneOfNoGivenNameRemovesWhatKilledRunsLeft) {
  const pid_t child = fork();
  if (child == 0) {
    const auto work = WorkFolder::make(folder_.path());
    write_bytes(work->path() + "/frames", "x");
    _exit(0);  // like a kill, after which no cleanup happens
  }
  waitpid(child, nullptr, 0);
  EXPECT_EQ(folder_.names().size(), 2u);
  {
    const auto one = WorkFolder::make(folder_.path()), two = WorkFolder::make(folder_.path());
    EXPECT_NE(one->shown_path(), two->shown_path());
    EXPECT_EQ(folder_.names().size(), 3u) << "the child's folder was left, or a folder in use was removed";
  }
  EXPECT_EQ(folder_.names(), Names{"precious"});
}

}  // namespace
}  // namespace multum
