// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/sandbox/helper_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <system_error>
#include <thread>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/machine.h"
#include "host/foundation/base/processes/sanitizers.h"
#include "host/foundation/base/processes/spawn_process.h"
#include "host/foundation/sandbox/helper_service.h"

namespace multum {
namespace {

using Clock = std::chrono::steady_clock;

constexpr auto kTick = std::chrono::milliseconds(50);
constexpr auto kGapMax = 4 * kTick;
constexpr std::uint64_t kAnswerMax = std::uint64_t{64} << 20;  // bytes
constexpr int kFirstFree = 16;                                 // a number above all descriptors that the child gets

[[noreturn]] void fail(const char* what) { fail_by_errno("a process that decodes files", what); }

// Moves a descriptor to a number that later dup2() calls do not overwrite.
int moved_away(int descriptor) {
  const int moved = ::fcntl(descriptor, F_DUPFD_CLOEXEC, kFirstFree);
  const int error = errno == EINVAL ? EMFILE : errno;  // the limit of open files is below kFirstFree
  ::close(descriptor);
  errno = error;
  if (moved < 0) fail("a file descriptor");
  return moved;
}

// The child stays in the group of this process, and ends when this process ends. If a terminal sends a signal to the
// group, only this process handles it.
pid_t spawn_helper(const std::string& program, int socket, int memory, int last_words) {
  return spawn_process({program}, {.files = {{last_words, STDOUT_FILENO},
                                             {last_words, STDERR_FILENO},
                                             {socket, kHelperSocket},
                                             {memory, kHelperMemory}},
                                   .has_empty_input = true,
                                   .blocked_signals = {{SIGINT, SIGTERM, SIGHUP, SIGQUIT}}});
}

// Returns the number of bytes that are resident and not shared.
std::uint64_t own_memory_bytes(pid_t pid) {
  std::FILE* file = std::fopen(fmt::format("/proc/{}/statm", pid).c_str(), "re");
  if (file == nullptr) return 0;
  unsigned long size = 0, resident = 0, shared = 0;
  const int found = std::fscanf(file, "%lu %lu %lu", &size, &resident, &shared);
  std::fclose(file);
  if (found != 3 || resident < shared) return 0;
  return std::uint64_t{resident - shared} * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

// Sums over all threads of the process.
std::chrono::nanoseconds processor_time(pid_t pid) {
  timespec used = {};
  clockid_t clock = {};
  if (::clock_getcpuclockid(pid, &clock) == 0) ::clock_gettime(clock, &used);
  return std::chrono::seconds(used.tv_sec) + std::chrono::nanoseconds(used.tv_nsec);
}

// 'R' after "TID (NAME) " (proc(5)) means that the thread is running, or waits only for a processor.
bool is_thread_ready(const std::string& folder) {
  std::FILE* file = std::fopen((folder + "/stat").c_str(), "re");
  if (file == nullptr) return false;
  std::array<char, 256> text{};
  const std::size_t count = std::fread(text.data(), 1, text.size(), file);
  std::fclose(file);
  const std::string_view line(text.data(), count);
  const std::size_t name_end = line.rfind(") ");
  return name_end != std::string_view::npos && line.substr(name_end + 2).starts_with('R');
}

// Returns whether any thread is ready to run. The first thread may be waiting, because libraries decode in other
// threads.
bool is_ready_to_run(pid_t pid) {
  std::error_code error;
  std::filesystem::directory_iterator threads(fmt::format("/proc/{}/task", pid), error), end;
  for (; !error && threads != end; threads.increment(error))
    if (is_thread_ready(threads->path().string())) return true;
  return false;
}

// Returns whether inherited limits may leave a child less memory than HelperLimits allow. The child's libraries also
// need address space, for which 360 MB were measured (OpenImageIO and assimp of Debian 12).
bool may_lack_memory(std::uint64_t memory_max) {
  constexpr std::uint64_t kLibraries = std::uint64_t{1} << 29;
  rlimit space = {}, data = {};
  ::getrlimit(RLIMIT_AS, &space);
  ::getrlimit(RLIMIT_DATA, &data);
  return (space.rlim_cur != RLIM_INFINITY && space.rlim_cur < memory_max + kLibraries) ||
         (data.rlim_max != RLIM_INFINITY && data.rlim_max < memory_max);
}

std::string text_of(std::chrono::milliseconds time) {
  return time.count() % 1000 == 0 ? fmt::format("{} s", time.count() / 1000) : fmt::format("{} ms", time.count());
}

// Returns the most informative line that a program printed before it ended. This is a line about an exception or a
// sanitizer, or the last line if there is no such line.
std::string essence(std::string_view said) {
  constexpr std::size_t kLengthMax = 200;
  std::string_view last, chosen;
  while (!said.empty()) {
    const std::string_view line = said.substr(0, said.find('\n'));
    said.remove_prefix(std::min(said.size(), line.size() + 1));
    if (!line.empty()) last = line;
    for (const std::string_view sign : {"what():", "ERROR:", "runtime error:"})
      if (chosen.empty() && line.find(sign) != std::string_view::npos) chosen = line;
  }
  std::string text(chosen.empty() ? last : chosen, 0, kLengthMax);
  for (char& c : text)
    if (c < ' ' || c > '~') c = '?';
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin);
}

}  // namespace

HelperProcess::HelperProcess(const std::string& program) : program_(program) {
  int pair[2];
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, pair) != 0) fail("socketpair");
  int theirs = -1, memory = -1;
  try {
    std::swap(socket_, pair[0]);
    theirs = moved_away(std::exchange(pair[1], -1));
    memory = moved_away(::dup(memory_.descriptor()));
    last_words_ = ::memfd_create("multum last words", MFD_CLOEXEC);
    if (last_words_ < 0) fail("memfd_create");
    last_words_ = moved_away(last_words_);
    ::fcntl(last_words_, F_SETFL, O_APPEND);
    pid_ = spawn_helper(program, theirs, memory, last_words_);
  } catch (...) {
    for (const int descriptor : {socket_, pair[1], theirs, memory, last_words_})
      if (descriptor >= 0) ::close(descriptor);
    throw;
  }
  ::close(theirs);
  ::close(memory);
}

HelperProcess::~HelperProcess() {
  kill_and_wait();
  ::close(last_words_);
}

int HelperProcess::kill_and_wait() {
  if (pid_ <= 0) return 0;
  ::close(std::exchange(socket_, -1));
  ::kill(pid_, SIGKILL);  // has no effect on a child that is already ending
  int status = 0;
  while (::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = -1;
  return status;
}

// The child has closed its end of the socket. Usually the child is exiting by itself, and its status tells the reason.
// A child that does not exit is killed.
int HelperProcess::wait_for_end() {
  constexpr int kTries = 200;
  int status = 0;
  for (int tries = 0; tries < kTries; ++tries) {
    const pid_t ended = ::waitpid(pid_, &status, WNOHANG);
    if (ended == pid_) {
      ::close(std::exchange(socket_, -1));
      pid_ = -1;
      return status;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  kill_and_wait();
  throw HelperEnded("stopped answering and was terminated", false);
}

void HelperProcess::end(const std::string& why) {
  kill_and_wait();
  throw HelperEnded(why + " and was terminated", false);
}

void HelperProcess::reap() {
  // The exit codes of a program that cannot be loaded (ld.so), and of a program that runs out of memory outside a
  // request (run_guarded()).
  constexpr int kNotLoaded = 127, kNoMemory = 4;
  const int status = wait_for_end();
  std::string how;
  bool lacked_memory = false;
  if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) {
    how = "exceeded its limit of processor time and was terminated";
  } else if (WIFSIGNALED(status)) {
    how = fmt::format("was terminated by signal {} ({})", WTERMSIG(status), ::sigdescr_np(WTERMSIG(status)));
    lacked_memory = WTERMSIG(status) == SIGKILL || may_lack_memory(memory_max_);
  } else {
    how = fmt::format("ended with exit code {}", WEXITSTATUS(status));
    lacked_memory = WEXITSTATUS(status) == kNotLoaded || WEXITSTATUS(status) == kNoMemory;
  }
  std::string said(65536, '\0');
  const ssize_t count = ::pread(last_words_, said.data(), said.size(), 0);
  said.resize(static_cast<std::size_t>(std::max<ssize_t>(0, count)));
  const std::string words = essence(said);
  throw HelperEnded(words.empty() ? how : how + ": " + words, lacked_memory);
}

// Sets the limits from outside, before the child gets the request.
void HelperProcess::hold_to(const HelperLimits& limits) {
  const auto used = std::chrono::duration_cast<std::chrono::seconds>(processor_time(pid_));
  rlimit processor = {};
  ::prlimit(pid_, RLIMIT_CPU, nullptr, &processor);
  const auto cores = static_cast<rlim_t>(processor_count());
  const auto seconds = static_cast<rlim_t>(limits.time_max.count()) / 1000 + 1;
  processor.rlim_cur = std::min(processor.rlim_max, static_cast<rlim_t>(used.count()) + 1 + seconds * cores);
  ::prlimit(pid_, RLIMIT_CPU, &processor, nullptr);
#ifndef MULTUM_SHADOW_MEMORY  // the shadow memory of sanitizers needs terabytes
  if (memory_max_ == limits.memory_max) return;
  rlimit memory = {};
  ::prlimit(pid_, RLIMIT_DATA, nullptr, &memory);
  memory.rlim_cur = std::min<rlim_t>(memory.rlim_max, limits.memory_max);
  ::prlimit(pid_, RLIMIT_DATA, &memory, nullptr);
#endif
  memory_max_ = limits.memory_max;
}

void HelperProcess::send(std::string_view request) {
  std::string frame(sizeof(std::uint64_t), '\0');
  const std::uint64_t size = request.size();
  std::memcpy(frame.data(), &size, sizeof(size));
  frame.append(request);
  for (std::size_t sent = 0; sent < frame.size();) {
    const ssize_t count = ::send(socket_, frame.data() + sent, frame.size() - sent, MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) reap();
    sent += static_cast<std::size_t>(count);
  }
}

// Adds the time since the last call, or only the processor time if the child is ready to run. A long gap means that
// this process was stopped or had no processor. The child's state during the gap is unknown, so the gap is capped.
void HelperProcess::Stopwatch::look(pid_t pid) {
  const auto now = Clock::now();
  const auto ran = processor_time(pid);
  const auto passed = std::min<std::chrono::nanoseconds>(now - looked, kGapMax);
  spent += is_ready_to_run(pid) ? std::min(passed, ran - ran_before) : passed;
  looked = now;
  ran_before = ran;
}

void HelperProcess::check(const HelperLimits& limits, Stopwatch& watch) {
  watch.look(pid_);
  if (watch.spent > limits.time_max) end("took more than " + text_of(limits.time_max));
  if (own_memory_bytes(pid_) > limits.memory_max)
    end(fmt::format("took more than {} bytes of memory", limits.memory_max));
}

std::string HelperProcess::receive(const HelperLimits& limits, const std::function<void()>& while_waiting) {
  Stopwatch watch{Clock::now(), processor_time(pid_), {}};
  std::array<char, 65536> bytes;
  received_.clear();
  for (;;) {
    std::uint64_t size = 0;
    if (received_.size() >= sizeof(size)) {
      std::memcpy(&size, received_.data(), sizeof(size));
      if (size > kAnswerMax) end(fmt::format("announced an answer of {} bytes", size));
      if (received_.size() > sizeof(size) + size) end("sent more bytes than it had announced");
      if (received_.size() == sizeof(size) + size) return received_.substr(sizeof(size));
    }
    pollfd waited = {socket_, POLLIN, 0};
    const int ready = ::poll(&waited, 1, static_cast<int>(kTick.count()));
    if (Clock::now() - watch.looked >= kTick) {
      check(limits, watch);
      if (while_waiting) while_waiting();
    }
    if (ready <= 0) continue;
    const ssize_t count = ::recv(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count < 0 && (errno == EINTR || errno == EAGAIN)) continue;
    if (count <= 0) reap();
    received_.append(bytes.data(), static_cast<std::size_t>(count));
  }
}

std::string HelperProcess::ask(std::string_view request, const HelperLimits& limits,
                               const std::function<void()>& while_waiting) {
  if (!is_alive()) throw HelperEnded("has ended before", false);
  try {
    hold_to(limits);
    send(request);
    return receive(limits, while_waiting);
  } catch (...) {
    kill_and_wait();  // otherwise its late answer would be taken for the answer to the next request
    throw;
  }
}

}  // namespace multum
