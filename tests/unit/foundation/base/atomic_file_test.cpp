// SPDX-License-Identifier: Apache-2.0
// Tests that a file is either complete or absent, and that no other file remains in its folder.
#include "host/foundation/base/files/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <regex>

#include "tests/unit/foundation/base/file_limit.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::Names;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

// Returns a process id that no process has: the id of a child that has been waited for.
pid_t dead_pid() {
  const pid_t child = fork();
  if (child == 0) _exit(0);
  waitpid(child, nullptr, 0);
  return child;
}

TEST(AtomicFileTest, AppearsOnCommitOnly) {
  const TemporaryFolder folder;
  {
    AtomicFile file(folder / "a.ndf.exr");
    write_bytes(file.open_path(), "text");
    EXPECT_FALSE(std::filesystem::exists(file.path()));
    file.commit();
    EXPECT_EQ(read_bytes(file.path()), "text");
    EXPECT_EQ(folder.names(), Names{"a.ndf.exr"});
  }
  EXPECT_EQ(folder.names(), Names{"a.ndf.exr"});
}

TEST(AtomicFileTest, WithoutCommitTheOldFileStaysAndNothingIsLeft) {
  const TemporaryFolder folder;
  write_bytes(folder / "a.txt", "old");
  {
    AtomicFile file(folder / "a.txt");
    write_bytes(file.open_path(), "new");
  }
  EXPECT_EQ(folder.names(), Names{"a.txt"});
  EXPECT_EQ(read_bytes(folder / "a.txt"), "old");
}

TEST(AtomicFileTest, TwoWritersOfOneNameDoNotMix) {
  const TemporaryFolder folder;
  AtomicFile one(folder / "a.txt"), two(folder / "a.txt");
  EXPECT_EQ(folder.names().size(), 2u);
  write_bytes(one.open_path(), "one");
  write_bytes(two.open_path(), "two");
  one.commit();
  EXPECT_EQ(read_bytes(folder / "a.txt"), "one");
  two.commit();
  EXPECT_EQ(read_bytes(folder / "a.txt"), "two");
}

TEST(AtomicFileTest, SweepsWhatDeadProcessesLeftAndNothingElse) {
  const TemporaryFolder folder;
  const std::string dead = ".multum-tmp-" + std::to_string(dead_pid()) + "-0-a.txt";
  const std::string living = ".multum-tmp-" + std::to_string(getppid()) + "-0-a.txt";
  const std::string other_name = ".multum-tmp-" + std::to_string(dead_pid()) + "-0-b.txt";
  const std::string no_pid = ".multum-tmp-x-0-a.txt";
  const std::string longer_name = ".multum-tmp-" + std::to_string(dead_pid()) + "-0-b-a.txt";
  for (const std::string& name : {dead, living, other_name, longer_name, no_pid, std::string("a.txt")})
    write_bytes(folder / name, "x");
  // Adds a name as this version makes it, but with random digits instead of a counter, and names of files of other
  // programs.
  const std::string random = ".multum-tmp-" + std::to_string(dead_pid()) + "-0123456789abcdef-a.txt";
  const std::string link = ".multum-tmp-" + std::to_string(dead_pid()) + "-1-a.txt";
  const std::string below = ".multum-tmp-" + std::to_string(dead_pid()) + "-2-a.txt";
  write_bytes(folder / random, "x");
  std::filesystem::create_symlink(folder / "a.txt", folder / link);
  std::filesystem::create_directory(folder / below);
  write_text_file(folder / "a.txt", "text");
  EXPECT_EQ(folder.names(), (Names{living, other_name, longer_name, no_pid, link, below, "a.txt"}));
}

// In a folder that several machines share, the process ids of other machines have no meaning on this machine.
TEST(AtomicFileTest, LeavesOtherMachinesFilesForADay) {
  const TemporaryFolder folder;
  const std::string young = ".multum-tmp-" + std::to_string(dead_pid()) + "-0-01234567-a.txt";
  const std::string old = ".multum-tmp-1-0-01234567-a.txt", old_other = ".multum-tmp-1-0-01234567-b.txt";
  for (const std::string& name : {young, old, old_other}) write_bytes(folder / name, "x");
  for (const std::string& name : {old, old_other})
    std::filesystem::last_write_time(folder / name,
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
  {
    const AtomicFile file(folder / "a.txt");
    Names names = folder.names();
    EXPECT_EQ(names.erase(young) + names.erase(old_other), 2u);
    // The name holds the process id, random digits, and then the name of the target.
    ASSERT_EQ(names.size(), 1u);
    EXPECT_TRUE(std::regex_match(
        *names.begin(), std::regex("\\.multum-tmp-" + std::to_string(getpid()) + "-[0-9a-f]{16}-[0-9a-f]{8}-a\\.txt")))
        << *names.begin();
  }
  EXPECT_EQ(folder.names(), (Names{young, old_other}));
}

TEST(AtomicFileTest, RefusesFoldersThatCannotTakeIt) {
  const TemporaryFolder folder;
  expect_error(ErrorCode::kUsage, {folder.path(), "is a folder", "expected the name of a file"},
               [&] { AtomicFile file(folder.path()); });
  expect_error(ErrorCode::kUsage, {"is a folder"}, [&] { AtomicFile file(folder / ""); });
  expect_error(ErrorCode::kEnvironment, {folder / "no/a.txt", "the folder " + (folder / "no"), "does not exist"},
               [&] { AtomicFile file(folder / "no/a.txt"); });
}

TEST(AtomicFileTest, RefusesAnUnwritableFolder) {
  if (geteuid() == 0) {
    // Permissions do not apply to the superuser. A child process without superuser rights has the same access as a
    // user.
    EXPECT_EXIT(
        {
          const TemporaryFolder folder;
          std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
          if (setuid(65534) != 0) _exit(9);
          try {
            AtomicFile file(folder / "a.txt");
            _exit(1);
          } catch (const Error& error) {
            std::fprintf(stderr, "%d %s\n", exit_code(error.code()), error.what());
            _exit(exit_code(error.code()));
          }
        },
        ::testing::ExitedWithCode(4), "4 .*/a.txt: cannot create a file in its folder: Permission denied");
    return;
  }
  const TemporaryFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  expect_error(ErrorCode::kEnvironment, {"cannot create a file"}, [&] { AtomicFile file(folder / "a.txt"); });
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0755));
}

TEST(AtomicFileTest, ARelativeNameGoesToTheWorkingFolder) {
  const TemporaryFolder folder;
  const auto before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  write_text_file("a.txt", "text");
  std::filesystem::current_path(before);
  EXPECT_EQ(read_bytes(folder / "a.txt"), "text");
}

TEST(AtomicFileTest, AWriteThatFailsIsAnErrorAndLeavesNothing) {
  const TemporaryFolder folder;
  {
    const testing::FileLimit none(0);  // writing fails, as on a full disk
    expect_error(ErrorCode::kEnvironment, {folder / "a.txt", "writing failed", "File too large"},
                 [&] { write_text_file(folder / "a.txt", std::string(1 << 20, 'x')); });
  }
  EXPECT_EQ(folder.names(), Names{});
}

TEST(AtomicFileTest, WhatIsNoFileIsNotWrittenOver) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "pipe").c_str(), 0666), 0);
  for (const std::string& name : {folder / "pipe", std::string("/dev/null")})
    expect_error(ErrorCode::kUsage, {name, "is a device, a pipe or a socket"}, [&] { AtomicFile file(name); });
}

TEST(AtomicFileTest, ANameOfAnyLengthIsWrittenOrRefusedAtOnce) {
  const TemporaryFolder folder;
  const std::string longest(kOutputNameMax, 'n');
  write_text_file(folder / longest, "text");
  EXPECT_EQ(read_bytes(folder / longest), "text");
  for (const std::size_t more : {1u, 56u, 5000u})
    expect_error(ErrorCode::kUsage, {"bytes, expected at most 200"},
                 [&] { AtomicFile file(folder / (longest + std::string(more, 'n'))); });
  expect_error(ErrorCode::kUsage, {"too long"}, [&] { AtomicFile file(folder / (std::string(300, 'f') + "/a.txt")); });
}

// A new link replaces an existing link and never the file to which that link leads.
TEST(AtomicFileTest, LinksAtTheFinalNameAreReplaced) {
  const TemporaryFolder folder;
  for (const bool is_hard : {false, true}) {
    write_bytes(folder / "precious", "kept");
    if (is_hard) std::filesystem::create_hard_link(folder / "precious", folder / "a.txt");
    else std::filesystem::create_symlink(folder / "precious", folder / "a.txt");
    write_text_file(folder / "a.txt", "text");
    EXPECT_EQ(read_bytes(folder / "precious"), "kept");
    EXPECT_EQ(read_bytes(folder / "a.txt"), "text");
    std::filesystem::remove(folder / "a.txt");
  }
}

// Another program replaces the temporary file while it is being written.
TEST(AtomicFileTest, ATemporaryFileThatWasReplacedIsNotPublished) {
  const TemporaryFolder folder;
  write_bytes(folder / "precious", "kept");
  for (const char* kind : {"link", "hard link", "pipe", "nothing"}) {
    {
      AtomicFile file(folder / "a.txt");
      const std::string temporary = folder / *folder.names().begin();
      std::filesystem::remove(temporary);
      if (kind == std::string("link")) std::filesystem::create_symlink(folder / "precious", temporary);
      if (kind == std::string("hard link")) std::filesystem::create_hard_link(folder / "precious", temporary);
      if (kind == std::string("pipe")) {
        ASSERT_EQ(mkfifo(temporary.c_str(), 0666), 0);
      }
      write_bytes(file.open_path(), "text");
      expect_error(ErrorCode::kEnvironment, {folder / "a.txt", "removed or replaced"}, [&] { file.commit(); });
      if (kind != std::string("nothing")) std::filesystem::remove(temporary);
    }
    EXPECT_EQ(folder.names(), Names{"precious"}) << kind;
    EXPECT_EQ(read_bytes(folder / "precious"), "kept") << kind;
  }
}

}  // namespace
}  // namespace multum
