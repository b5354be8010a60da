// SPDX-License-Identifier: Apache-2.0
// A file appears whole or not at all, and nothing else stays in its folder.
#include "host/base/files/atomic_file.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <regex>

#include "tests/unit/base/test_folder.h"

namespace multum {
namespace {

using testing::expect_error;
using testing::Names;
using testing::read_bytes;
using testing::TemporaryFolder;
using testing::write_bytes;

// A process id that surely belongs to nobody: of a child that has been waited for.
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
    EXPECT_TRUE(file.temporary_path().ends_with(".ndf.exr")) << file.temporary_path();
    write_bytes(file.temporary_path(), "text");
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
    write_bytes(file.temporary_path(), "new");
  }
  EXPECT_EQ(folder.names(), Names{"a.txt"});
  EXPECT_EQ(read_bytes(folder / "a.txt"), "old");
}

TEST(AtomicFileTest, TwoWritersOfOneNameDoNotMix) {
  const TemporaryFolder folder;
  AtomicFile one(folder / "a.txt"), two(folder / "a.txt");
  EXPECT_NE(one.temporary_path(), two.temporary_path());
  write_bytes(one.temporary_path(), "one");
  write_bytes(two.temporary_path(), "two");
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
  const AtomicFile file(folder / "a.txt");
  EXPECT_EQ(folder.names(), (Names{living, other_name, longer_name, no_pid, "a.txt"}));
}

// On a folder that machines share, their processes' numbers say nothing here.
TEST(AtomicFileTest, LeavesOtherMachinesFilesForADay) {
  const TemporaryFolder folder;
  const std::string young = ".multum-tmp-" + std::to_string(dead_pid()) + "-0-01234567-a.txt";
  const std::string old = ".multum-tmp-1-0-01234567-a.txt", old_other = ".multum-tmp-1-0-01234567-b.txt";
  for (const std::string& name : {young, old, old_other}) write_bytes(folder / name, "x");
  for (const std::string& name : {old, old_other})
    std::filesystem::last_write_time(folder / name,
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
  const AtomicFile file(folder / "a.txt");
  EXPECT_EQ(folder.names(), (Names{young, old_other}));
  // Its own name has the place that it is of, after both numbers.
  const std::string name = std::filesystem::path(file.temporary_path()).filename().string();
  EXPECT_TRUE(
      std::regex_match(name, std::regex("\\.multum-tmp-" + std::to_string(getpid()) + "-\\d+-[0-9a-f]{8}-a\\.txt")))
      << name;
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
    // Permissions do not bind the superuser; a child without its rights sees what a user sees.
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
        ::testing::ExitedWithCode(4), "4 .*/a.txt: the folder .* cannot be written: Permission denied");
    return;
  }
  const TemporaryFolder folder;
  std::filesystem::permissions(folder.path(), std::filesystem::perms(0555));
  expect_error(ErrorCode::kEnvironment, {"cannot be written"}, [&] { AtomicFile file(folder / "a.txt"); });
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
  // No file may grow: as on a full disk, writing fails.
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &none), 0);
  expect_error(ErrorCode::kEnvironment, {folder / "a.txt", "writing failed", "File too large"},
               [&] { write_text_file(folder / "a.txt", std::string(1 << 20, 'x')); });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(folder.names(), Names{});
}

// Somebody who may write to the folder knows the names that are next.
TEST(AtomicFileTest, ALinkUnderTheTemporaryNameIsNotFollowed) {
  const TemporaryFolder folder;
  write_bytes(folder / "precious", "kept");
  AtomicFile probe(folder / "a.txt");
  const std::string next = probe.temporary_path();
  std::smatch parts;
  ASSERT_TRUE(std::regex_match(next, parts, std::regex("(.*-)(\\d+)(-[0-9a-f]{8}-a\\.txt)"))) << next;
  std::filesystem::create_symlink(folder / "precious",
                                  parts[1].str() + std::to_string(std::stoi(parts[2]) + 1) + parts[3].str());
  expect_error(ErrorCode::kEnvironment, {folder / "a.txt", "File exists"},
               [&] { write_text_file(folder / "a.txt", "text"); });
  EXPECT_EQ(read_bytes(folder / "precious"), "kept");
}

}  // namespace
}  // namespace multum
