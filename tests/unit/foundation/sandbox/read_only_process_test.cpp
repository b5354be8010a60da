// SPDX-License-Identifier: Apache-2.0
// Tests what a process that decodes files can do. The test runs in child processes, because a process cannot leave its
// confinement. The last test looks at the program multum-decode itself.
#include "host/foundation/sandbox/read_only_process.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/fs.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/un.h>
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

// Returns whether a call failed because it is forbidden. The filter sees a call before the kernel examines it.
bool forbidden(long result) { return result == -1 && errno == EPERM; }
bool forbids_writing(long result) { return result == -1 && errno == EACCES; }

class ReadOnlyProcessTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (confined([] { return 0; }) == 100) GTEST_SKIP() << "no seccomp here, or a build with a sanitizer";
    write_text_file(file_, "text");
    fs::create_symlink("file", link_);
  }
  const int socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_un name_{AF_UNIX, "/dev/log"};
  const TemporaryFolder folder_;
  const std::string file_ = folder_ / "file", link_ = folder_ / "link", other_ = folder_ / "other";
};

TEST_F(ReadOnlyProcessTest, FilesAreReadAndNotChanged) {
  const char* const file = file_.c_str();
  const char* const other = other_.c_str();
  const std::vector<std::function<bool()>> changes = {
      [&] { return forbids_writing(::open(file, O_WRONLY)); },
      [&] { return forbids_writing(::open(file, O_RDWR)); },
      [&] { return forbids_writing(::open(file, O_RDONLY | O_TRUNC)); },
      [&] { return forbids_writing(::open(other, O_RDONLY | O_CREAT, 0600)); },
      [&] { return forbids_writing(::open(link_.c_str(), O_WRONLY)); },
      [&] { return forbids_writing(::open((folder_ / "").c_str(), O_TMPFILE | O_RDWR, 0600)); },
#ifdef SYS_open  // arm64 has only openat
      [&] { return forbids_writing(::syscall(SYS_open, file, O_WRONLY)); },
#endif
      [&] { return ::syscall(SYS_openat2, AT_FDCWD, file, nullptr, 0) == -1 && errno == ENOSYS; },
      [&] { return forbidden(::creat(other, 0600)) || errno == EACCES; },
      [&] { return forbidden(::truncate(file, 0)); },
      [&] { return forbidden(::unlink(file)); },
      [&] { return forbidden(::rename(file, other)); },
      [&] { return forbidden(::link(file, other)); },
      [&] { return forbidden(::symlink(file, other)); },
      [&] { return forbidden(::mkdir(other, 0700)); },
      [&] { return forbidden(::mkfifo(other, 0600)); },
      [&] { return forbidden(::chmod(file, 0777)); },
      [&] { return forbidden(::fchmod(::open(file, O_RDONLY), 0777)); },
      [&] { return forbidden(::chown(file, ::getuid(), ::getgid())); },
      [&] { return forbidden(::utimes(file, nullptr)); },
      [&] { return forbidden(::setxattr(file, "user.multum", "x", 1, 0)); },
      [&] { return ::flock(::open(file, O_RDONLY), LOCK_EX) == -1 && errno == ENOSYS; },
      [&] { return forbidden(::fcntl(::open(file, O_RDONLY), F_SETLEASE, F_RDLCK)); },
      [&] {
        long flags = 0;
        return ::ioctl(::open(file, O_RDONLY), FS_IOC_SETFLAGS, &flags) == -1 && errno == ENOTTY;
      },
  };
  for (std::size_t i = 0; i < changes.size(); ++i)
    EXPECT_EQ(confined([&] { return changes[i]() ? 0 : 1; }), 0) << "change " << i;
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
  const std::vector<std::function<bool()>> calls = {
      [] { return forbidden(::socket(AF_INET, SOCK_STREAM, 0)); },
      [] { return forbidden(::socket(AF_UNIX, SOCK_STREAM, 0)); },
      [] {
        int ends[2];
        return forbidden(::socketpair(AF_UNIX, SOCK_DGRAM, 0, ends));
      },
      [&] { return forbidden(::sendto(socket_, "x", 1, 0, reinterpret_cast<sockaddr*>(&name_), sizeof(name_))); },
      [] { return forbidden(::execl("/bin/true", "true", nullptr)); },
      [] { return forbidden(::fork()); },
      [] { return forbidden(::syscall(SYS_clone, CLONE_NEWUSER | SIGCHLD, nullptr, nullptr, nullptr, nullptr)); },
      [&] { return forbidden(::kill(parent, 0)); },
      [] { return forbidden(::kill(-1, 0)); },
      [&] { return forbidden(::fcntl(socket_, F_SETOWN, parent)); },
      [&] { return forbidden(::ptrace(PTRACE_ATTACH, parent, nullptr, nullptr)); },
      [&] { return forbidden(::syscall(SYS_pidfd_open, parent, 0)); },
      [&] { return forbidden(::setpriority(PRIO_PROCESS, static_cast<id_t>(parent), 19)); },
      [&] { return forbidden(::prlimit(parent, RLIMIT_CORE, nullptr, nullptr)); },
      [] { return forbidden(::shmget(IPC_PRIVATE, 4096, 0600)); },
      [] { return forbidden(::syscall(SYS_msgctl, 0, 0, nullptr)); },
      [] { return forbidden(::syscall(SYS_io_uring_setup, 1, nullptr)); },
      [] { return forbidden(::syscall(SYS_unshare, 0)); },
      [&] { return forbids_writing(::open(("/proc/" + std::to_string(parent) + "/mem").c_str(), O_RDWR)); },
  };
  for (std::size_t i = 0; i < calls.size(); ++i)
    EXPECT_EQ(confined([&] { return calls[i]() ? 0 : 1; }), 0) << "call " << i;
  // A call for another process that pretends success does nothing.
  cpu_set_t before, after, one;
  CPU_ZERO(&one);
  CPU_SET(0, &one);
  ASSERT_EQ(::sched_getaffinity(0, sizeof(before), &before), 0);
  EXPECT_EQ(confined([&] { return ::sched_setaffinity(parent, sizeof(one), &one); }), 0);
  ASSERT_EQ(::sched_getaffinity(0, sizeof(after), &after), 0);
  EXPECT_TRUE(CPU_EQUAL(&before, &after));
}

TEST_F(ReadOnlyProcessTest, LimitsAreNotRaised) {
  EXPECT_EQ(confined([] {
              rlimit limit{};
              if (::getrlimit(RLIMIT_DATA, &limit) != 0) return 1;
              if (!forbidden(::setrlimit(RLIMIT_DATA, &limit))) return 2;
              if (::mmap(nullptr, 4096, PROT_READ, MAP_SHARED | MAP_ANONYMOUS, -1, 0) != MAP_FAILED) return 3;
              if (::mmap(nullptr, 4096, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) == MAP_FAILED) return 4;
              return ::memfd_create("m", 0) == -1 && errno == ENOSYS ? 0 : 5;
            }),
            0);
}

TEST_F(ReadOnlyProcessTest, ThreadsWorkAndAreConfinedToo) {
  EXPECT_EQ(confined([&] {
              int result = 1;
              std::thread([&] { result = forbids_writing(::open(file_.c_str(), O_WRONLY)) ? 0 : 2; }).join();
              return result;
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
