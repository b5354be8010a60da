// SPDX-License-Identifier: Apache-2.0
#include "host/base/child_process.h"

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>

#include "host/base/error.h"

namespace multum {
namespace {

double seconds(const timeval& time) {
  return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
}

// Linux counts in KiB.
std::uint64_t peak_memory_bytes(const rusage& usage) { return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024; }

}  // namespace

ChildResult run_child(const std::vector<std::string>& arguments) {
  MULTUM_CHECK(!arguments.empty());
  int pipe_ends[2];
  if (pipe(pipe_ends) != 0) throw Error(ErrorCode::kEnvironment, std::string("pipe: ") + std::strerror(errno));

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, pipe_ends[1], STDERR_FILENO);
  posix_spawn_file_actions_addclose(&actions, pipe_ends[0]);
  posix_spawn_file_actions_addclose(&actions, pipe_ends[1]);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t pid = 0;
  const auto start = std::chrono::steady_clock::now();
  const int spawn_error = posix_spawnp(&pid, argv[0], &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  close(pipe_ends[1]);
  if (spawn_error != 0) {
    close(pipe_ends[0]);
    throw Error(ErrorCode::kEnvironment, arguments[0] + ": cannot be started: " + std::strerror(spawn_error));
  }

  ChildResult result{-1, 0, {}, {}};
  std::array<char, 4096> buffer;
  for (;;) {
    const ssize_t count = read(pipe_ends[0], buffer.data(), buffer.size());
    if (count > 0) result.output.append(buffer.data(), static_cast<std::size_t>(count));
    else if (count == 0 || errno != EINTR) break;
  }
  close(pipe_ends[0]);
  int status = 0;
  rusage usage = {};
  while (wait4(pid, &status, 0, &usage) < 0 && errno == EINTR) {
  }
  result.usage = {std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(),
                  seconds(usage.ru_utime), seconds(usage.ru_stime), peak_memory_bytes(usage)};
  if (WIFEXITED(status)) result.exit_code = WEXITSTATUS(status);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

std::uint64_t own_peak_memory_bytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return peak_memory_bytes(usage);
}

}  // namespace multum
