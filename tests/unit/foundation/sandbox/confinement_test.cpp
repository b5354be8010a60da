// SPDX-License-Identifier: Apache-2.0
// Tests which files a confined process can open. The test runs in a child process, because a process cannot leave its
// confinement.
#include "host/foundation/sandbox/confinement.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/landlock.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <filesystem>

#include "host/foundation/base/files/atomic_file.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

bool opens(const std::string& path, int flags) {
  const int file = ::open(path.c_str(), flags | O_CLOEXEC, 0600);
  if (file >= 0) ::close(file);
  return file >= 0;
}

// Runs `work` in a confined child process. Returns the exit code, which is the number of the fault that the child
// found.
template <typename Work>
int in_child(const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(work());
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ConfinementTest, NothingElseIsOpenedByAnyName) {
  if (!can_confine()) GTEST_SKIP() << "this kernel has no Landlock";
  TemporaryFolder folder;
  const std::string read = folder / "read", write = folder / "write", outside = folder / "outside";
  for (const std::string& path : {read, write, outside}) {
    fs::create_directory(path);
    write_text_file(path + "/file", "text");
  }
  fs::create_symlink(outside + "/file", read + "/link");
  fs::create_symlink(outside, write + "/door");
  const int wrong = in_child([&] {
    Confinement allowed;
    allowed.readable = {read, folder / "not_there"};
    allowed.writable = {write};
    if (!confine_this_thread(allowed)) return 1;
    if (!opens(read + "/file", O_RDONLY)) return 2;
    if (opens(read + "/file", O_WRONLY)) return 3;
    if (opens(read + "/new", O_WRONLY | O_CREAT)) return 4;
    if (!opens(write + "/file", O_RDWR)) return 5;
    if (!opens(write + "/new", O_WRONLY | O_CREAT)) return 6;
    if (std::rename((write + "/new").c_str(), (write + "/newer").c_str()) != 0) return 7;
    if (opens(outside + "/file", O_RDONLY)) return 8;
    if (opens(read + "/link", O_RDONLY)) return 9;
    if (opens(write + "/door/file", O_RDONLY)) return 10;
    if (opens(write + "/door/new", O_WRONLY | O_CREAT)) return 11;
    if (std::rename((write + "/newer").c_str(), (outside + "/stolen").c_str()) == 0) return 12;
    if (::link((write + "/file").c_str(), (outside + "/linked").c_str()) == 0) return 13;
    if (opens("/etc/passwd", O_RDONLY)) return 14;
    // A process that a confined process starts has the same limits.
    return in_child([&] { return opens(outside + "/file", O_RDONLY) ? 15 : 0; });
  });
  EXPECT_EQ(wrong, 0);
}

// Tests only limits that this machine's kernel supports.
TEST(ConfinementTest, NobodyElseIsReached) {
  const long version = ::syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 6) GTEST_SKIP() << "this kernel's Landlock cannot restrict TCP or signals";
  const int listener = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t bytes = sizeof(address);
  auto* const any = reinterpret_cast<sockaddr*>(&address);
  ASSERT_EQ(::bind(listener, any, bytes), 0);
  ASSERT_EQ(::listen(listener, 8), 0);
  ASSERT_EQ(::getsockname(listener, any, &bytes), 0);
  const pid_t parent = ::getpid();
  const auto reach = [&](bool is_confined) {
    return in_child([&] {
      if (is_confined && !confine_this_thread({})) return 8;
      const int line = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
      const int is_connected = ::connect(line, any, bytes) == 0 ? 1 : 0, may_kill = ::kill(parent, 0) == 0 ? 2 : 0;
      return is_connected + may_kill + (::kill(::getpid(), 0) == 0 ? 0 : 4);
    });
  };
  EXPECT_EQ(reach(false), 3) << "the test itself does not work";
  EXPECT_EQ(reach(true), 0);
  ::close(listener);
}

TEST(ConfinementTest, SaysWhichPartHoldsAPath) {
  TemporaryFolder folder;
  fs::create_directory(folder / "real");
  fs::create_directory_symlink(folder / "real", folder / "link");
  Confinement allowed;
  allowed.readable = {folder / "link", folder / "not_there", ""};
  EXPECT_EQ(part_that_holds(allowed, folder / "real/data/token"), folder / "link");
  EXPECT_EQ(part_that_holds(allowed, folder / "real"), folder / "link");
  EXPECT_EQ(part_that_holds(allowed, folder / "really"), "");
  EXPECT_EQ(part_that_holds(allowed, folder / "not_there/x"), folder / "not_there");
  EXPECT_EQ(part_that_holds(allowed, folder / ""), "");
}

TEST(ConfinementTest, ProgramsStillRun) {
  if (!can_confine()) GTEST_SKIP() << "this kernel has no Landlock";
  const int wrong = in_child([] {
    if (!confine_this_thread(system_confinement([](const char*) { return std::string(); }))) return 1;
    ::execl("/bin/true", "true", nullptr);
    return 2;
  });
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace multum
