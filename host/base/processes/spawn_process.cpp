// SPDX-License-Identifier: Apache-2.0
#include "host/base/processes/spawn_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

#include "host/base/error.h"
#include "host/base/system_failure.h"

namespace multum {
namespace {

class SpawnActions {
 public:
  explicit SpawnActions(const SpawnSettings& settings) {
    posix_spawn_file_actions_init(&actions_);
    if (settings.has_empty_input) posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    int last = STDERR_FILENO;
    for (const auto& [ours, theirs] : settings.files) {
      posix_spawn_file_actions_adddup2(&actions_, ours, theirs);
      last = std::max(last, theirs);
    }
    posix_spawn_file_actions_addclosefrom_np(&actions_, last + 1);
  }
  ~SpawnActions() { posix_spawn_file_actions_destroy(&actions_); }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_;
};

class SpawnAttributes {
 public:
  explicit SpawnAttributes(const SpawnSettings& settings) {
    posix_spawnattr_init(&attributes_);
    int flags = (settings.has_own_group ? POSIX_SPAWN_SETPGROUP : 0) | POSIX_SPAWN_SETSIGDEF;
    // This process ignores the signal of files that grow too large, and a program inherits that: another's may not
    // look at what its writes return.
    sigset_t as_at_start;
    sigemptyset(&as_at_start);
    sigaddset(&as_at_start, SIGXFSZ);
    if (settings.blocked_signals) {
      flags |= POSIX_SPAWN_SETSIGMASK;
      sigset_t blocked;
      sigemptyset(&blocked);
      for (const int signal : *settings.blocked_signals) sigaddset(&blocked, signal);
      posix_spawnattr_setsigmask(&attributes_, &blocked);
      sigfillset(&as_at_start);
    }
    posix_spawnattr_setsigdefault(&attributes_, &as_at_start);
    posix_spawnattr_setflags(&attributes_, static_cast<short>(flags));
  }
  ~SpawnAttributes() { posix_spawnattr_destroy(&attributes_); }
  SpawnAttributes(const SpawnAttributes&) = delete;
  SpawnAttributes& operator=(const SpawnAttributes&) = delete;
  const posix_spawnattr_t* get() const { return &attributes_; }

 private:
  posix_spawnattr_t attributes_;
};

}  // namespace

pid_t spawn_process(const std::vector<std::string>& arguments, const SpawnSettings& settings) {
  MULTUM_CHECK(!arguments.empty());
  const SpawnActions actions(settings);
  const SpawnAttributes attributes(settings);
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  pid_t pid = -1;
  const auto start = settings.is_in_path ? &posix_spawnp : &posix_spawn;
  const int error = start(&pid, argv[0], actions.get(), attributes.get(), argv.data(), environ);
  if (error != 0) throw Error(ErrorCode::kEnvironment, arguments[0] + ": cannot be started: " + errno_text(error));
  return pid;
}

}  // namespace multum
