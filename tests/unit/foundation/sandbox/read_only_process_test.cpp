// SPDX-License-Identifier: Apache-2.0
// Tests what a process that decodes files can do. The test runs in child processes, because a process cannot leave its
// confinement. The last test looks at the program multum-decode itself.
#include "host/foundation/sandbox/read_only_process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "host/foundation/base/files/atomic_file.h"
#include "host/foundation/sandbox/decoding_child.h"
#include "host/foundation/sandbox/helper_service.h"
#include "tests/unit/foundation/base/test_folder.h"

namespace multum {
namespace {

namespace fs = std::filesystem;
using testing::TemporaryFolder;

// Runs `work` in a child process that is confined to reading. Returns its exit code, or -1 for another end.
template <typename Work>
int confined(const Work& work) {
  const pid_t child = ::fork();
  if (child == 0) ::_exit(confine_to_reading() ? work() : 100);
  int status = 0;
  ::waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

// Returns whether a call failed because it is forbidden.
bool forbidden(long result) { return result == -1 && (errno == EPERM || errno == EACCES); }

class ReadOnlyProcessTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (confined([] { return 0; }) == 100) GTEST_SKIP() << "no seccomp here, or a build with the address sanitizer";
    write_text_file(file_, "text");
    fs::create_symlink("file", link_);
  }
  const TemporaryFolder folder_;
  const std::string file_ = folder_ / "file", link_ = folder_ / "link", other_ = folder_ / "other";
};

TEST_F(ReadOnlyProcessTest, FilesAreReadAndNotChanged) {
  const char* const file = file_.c_str();
  const char* const other = other_.c_str();
  const std::vector<std::function<long()>> changes = {
      [&] { return ::open(file, O_WRONLY); },
      [&] { return ::open(file, O_RDWR); },
      [&] { return ::open(file, O_RDONLY | O_TRUNC); },
      [&] { return ::open(other, O_RDONLY | O_CREAT, 0600); },
      [&] { return ::open(link_.c_str(), O_WRONLY); },
      [&] { return ::open((folder_ / "").c_str(), O_TMPFILE | O_RDWR, 0600); },
      [&] { return ::creat(other, 0600); },
      [&] { return ::truncate(file, 0); },
      [&] { return ::unlink(file); },
      [&] { return ::rename(file, other); },
      [&] { return ::link(file, other); },
      [&] { return ::symlink(file, other); },
      [&] { return ::mkdir(other, 0700); },
      [&] { return ::mkfifo(other, 0600); },
      [&] { return ::chmod(file, 0777); },
      [&] { return ::fchmod(::open(file, O_RDONLY), 0777); },
      [&] { return ::chown(file, ::getuid(), ::getgid()); },
      [&] { return ::utimes(file, nullptr); },
      [&] { return ::setxattr(file, "user.multum", "x", 1, 0); },
  };
  for (std::size_t i = 0; i < changes.size(); ++i)
    EXPECT_EQ(confined([&] { return forbidden(changes[i]()) ? 0 : 1; }), 0) << "change " << i;
  EXPECT_EQ(confined([&] {
              char text[5] = "";
              const int opened = ::open(file, O_RDONLY | O_CLOEXEC);
              return ::read(opened, text, 4) == 4 && std::string(text) == "text" ? 0 : 1;
            }),
            0);
  EXPECT_FALSE(fs::exists(other_));
  std::string text;
  std::getline(std::ifstream(file_), text);
  EXPECT_EQ(text, "text");
}

TEST_F(ReadOnlyProcessTest, NoProgramSocketOrOtherProcessIsReached) {
  const pid_t parent = ::getpid();
  const std::vector<std::function<long()>> calls = {
      [] { return ::socket(AF_INET, SOCK_STREAM, 0); },
      [] { return ::socket(AF_UNIX, SOCK_STREAM, 0); },
      [] { return ::execl("/bin/true", "true", nullptr); },
      [&] { return ::kill(parent, 0); },
      [&] { return ::kill(-1, 0); },
      [&] { return ::ptrace(PTRACE_ATTACH, parent, nullptr, nullptr); },
      [&] { return ::syscall(SYS_pidfd_open, parent, 0); },
      [&] { return ::setpriority(PRIO_PROCESS, static_cast<id_t>(parent), 19); },
      [&] { return ::prlimit(parent, RLIMIT_CORE, nullptr, nullptr); },
      [] { return ::shmget(IPC_PRIVATE, 4096, 0600); },
      [] { return ::syscall(SYS_io_uring_setup, 1, nullptr); },
      [] { return ::syscall(SYS_unshare, 0); },
      [&] { return ::open(("/proc/" + std::to_string(parent) + "/mem").c_str(), O_RDWR); },
  };
  for (std::size_t i = 0; i < calls.size(); ++i)
    EXPECT_EQ(confined([&] { return forbidden(calls[i]()) ? 0 : 1; }), 0) << "call " << i;
}

TEST_F(ReadOnlyProcessTest, ItsThreadsAndChildrenAreConfinedToo) {
  const auto cannot_write = [&] { return forbidden(::open(file_.c_str(), O_WRONLY)) ? 0 : 1; };
  EXPECT_EQ(confined([&] {
              int result = 1;
              std::thread([&] { result = cannot_write(); }).join();
              return result;
            }),
            0);
  EXPECT_EQ(confined([&] {
              const pid_t child = ::fork();
              if (child == 0) ::_exit(cannot_write());
              int status = 0;
              ::waitpid(child, &status, 0);
              return WEXITSTATUS(status);
            }),
            0);
}

// abort() still ends the process by its signal, so that the cause of a crash is reported.
TEST_F(ReadOnlyProcessTest, AbortIsStillSeen) {
  EXPECT_EXIT(
      {
        confine_to_reading();
        std::abort();
      },
      ::testing::KilledBySignal(SIGABRT), "");
}

std::string line_of(const std::string& path, const std::string& key) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with(key)) return line.substr(key.size());
  return "";
}

// Every thread of multum-decode has a filter (mode 2) and cannot gain rights.
TEST_F(ReadOnlyProcessTest, MultumDecodeIsConfined) {
  int ends[2];
  ASSERT_EQ(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends), 0);
  const std::string program = decoder_beside_this_program();
  ASSERT_TRUE(fs::exists(program)) << program;
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(ends[1], kHelperSocket);
    ::execl(program.c_str(), program.c_str(), nullptr);
    ::_exit(127);
  }
  ::close(ends[1]);
  // The child waits for requests, with a second thread that waits for the end of this process.
  const std::string tasks = "/proc/" + std::to_string(child) + "/task";
  const auto count = [&] {
    std::error_code gone;
    std::size_t threads = 0;
    for (fs::directory_iterator at(tasks, gone), end; !gone && at != end; at.increment(gone)) ++threads;
    return threads;
  };
  for (int turn = 0; turn < 1000 && count() < 2; ++turn) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  EXPECT_EQ(count(), 2u);
  for (const auto& task : fs::directory_iterator(tasks)) {
    EXPECT_EQ(line_of(task.path() / "status", "Seccomp:\t"), "2");
    EXPECT_EQ(line_of(task.path() / "status", "NoNewPrivs:\t"), "1");
  }
  ::close(ends[0]);
  ::waitpid(child, nullptr, 0);
}

}  // namespace
}  // namespace multum
