// SPDX-License-Identifier: Apache-2.0
#include "host/foundation/base/processes/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>

#include "host/foundation/base/error.h"
#include "host/foundation/base/processes/sanitizers.h"
#include "host/foundation/base/processes/spawn_process.h"
#include "host/foundation/base/stopwatch.h"

namespace multum {
namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// Linux reports this value in KiB.
std::uint64_t peak_memory_bytes(const rusage& usage) { return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024; }

// Sets the limits of a child from outside, immediately after its start and before the child reads any untrusted file.
void hold_to(pid_t pid, const ChildLimits& limits) {
  if (limits.niceness > 0) ::setpriority(PRIO_PROCESS, static_cast<id_t>(pid), limits.niceness);
#ifndef MULTUM_SHADOW_MEMORY  // the shadow memory of sanitizers needs terabytes
  if (limits.memory_max > 0) {
    const rlimit memory = {limits.memory_max, limits.memory_max};
    ::prlimit(pid, RLIMIT_DATA, &memory, nullptr);
  }
#endif
}

// Reads the output of the child until the child closes its end of the pipe. Returns false if the child was killed
// because it took too long or was cancelled.
bool read_output(int pipe_end, pid_t pid, const ChildLimits* limits, std::string& output) {
  const Stopwatch stopwatch;
  std::array<char, 4096> buffer;
  bool is_killed = false;
  for (;;) {
    if (limits != nullptr && !is_killed) {
      pollfd waited = {pipe_end, POLLIN, 0};
      const bool has_more = poll(&waited, 1, 100) > 0;
      is_killed = stopwatch.seconds() > std::chrono::duration<double>(limits->time_max).count() ||
                  output.size() > limits->output_max || (limits->is_cancelled && limits->is_cancelled());
      if (is_killed) ::kill(-pid, SIGKILL);
      if (!has_more) continue;
    }
    const ssize_t count = read(pipe_end, buffer.data(), buffer.size());
    if (count > 0) output.append(buffer.data(), static_cast<std::size_t>(count));
    else if (count == 0 || errno != EINTR) return !is_killed;
  }
}

ChildResult run(const std::vector<std::string>& arguments, const ChildLimits* limits) {
  MULTUM_CHECK(!arguments.empty());
  int pipe_ends[2];
  // Without O_CLOEXEC, the pipe would stay open in a child that another thread starts at the same time.
  if (pipe2(pipe_ends, O_CLOEXEC) != 0) fail_by_errno(arguments[0], "cannot create a pipe for its output");
  const Stopwatch stopwatch;
  pid_t pid = 0;
  try {
    pid = spawn_process(arguments, {.files = {{pipe_ends[1], STDOUT_FILENO}, {pipe_ends[1], STDERR_FILENO}},
                                    .has_own_group = limits != nullptr,
                                    .is_in_path = true,
                                    .ends_with_thread = true});
  } catch (const Error&) {
    close(pipe_ends[0]);
    close(pipe_ends[1]);
    throw;
  }
  close(pipe_ends[1]);
  if (limits != nullptr) hold_to(pid, *limits);
  ChildResult result{-1, 0, {}, {}};
  result.is_over_time = !read_output(pipe_ends[0], pid, limits, result.output);
  close(pipe_ends[0]);
  int status = 0;
  rusage usage = {};
  while (wait4(pid, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  result.usage = {stopwatch.seconds(), seconds(usage.ru_utime), seconds(usage.ru_stime), peak_memory_bytes(usage)};
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

}  // namespace

ChildResult run_child(const std::vector<std::string>& arguments) { return run(arguments, nullptr); }

ChildResult run_child(const std::vector<std::string>& arguments, const ChildLimits& limits) {
  return run(arguments, &limits);
}

std::uint64_t own_peak_memory_bytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return peak_memory_bytes(usage);
}

}  // namespace multum
