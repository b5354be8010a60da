// SPDX-License-Identifier: Apache-2.0
// Uses vfork(), because posix_spawn() cannot make a child end with its parent. Between vfork() and exec, the child
// shares the memory of this process. Therefore the child only makes system calls, with arguments that were prepared
// before vfork().
#include "host/foundation/base/processes/spawn_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <utility>

#include "host/foundation/base/error.h"
#include "host/foundation/base/files/open_file.h"
#include "host/foundation/base/system_failure.h"

namespace multum {
namespace {

[[noreturn]] void cannot_start(const std::string& program, int error) {
  throw Error(ErrorCode::kEnvironment, program + ": cannot be started: " + errno_text(error));
}

// The steps of the child before exec.
struct ChildStart {
  const SpawnSettings& settings;
  char* const* argv;
  sigset_t mask;    // signal mask of the child
  int failure_end;  // end of a pipe through which the child reports the number of an error
  int last_file;    // the highest descriptor that the child keeps
  pid_t starter;
};

void check_call(const ChildStart& start, long result) {
  if (result >= 0) return;
  const int error = errno;
  [[maybe_unused]] const ssize_t ignored = ::write(start.failure_end, &error, sizeof(error));
  ::_exit(127);
}

// Arranges the files of the child. The end of the pipe comes after the files that the child keeps, and exec closes it.
void arrange_files(ChildStart& start) {
  if (start.settings.has_empty_input) {
    const int nothing = ::open("/dev/null", O_RDONLY);
    check_call(start, nothing);
    if (nothing != STDIN_FILENO) check_call(start, ::dup2(nothing, STDIN_FILENO));
  }
  for (const auto& [ours, theirs] : start.settings.files)
    check_call(start, ours == theirs ? ::fcntl(theirs, F_SETFD, 0) : ::dup2(ours, theirs));
  const int last = start.last_file + 1;
  if (start.failure_end != last) check_call(start, ::dup3(start.failure_end, last, O_CLOEXEC));
  start.failure_end = last;
  ::closefrom(last + 1);
}

// This function runs while all signals are blocked, because the handlers belong to this process.
void arrange_signals(const ChildStart& start) {
  for (int signal = 1; signal < NSIG; ++signal) {
    struct sigaction now {};
    if (::sigaction(signal, nullptr, &now) != 0 || now.sa_handler == SIG_DFL) continue;
    // This process ignores SIGXFSZ, the signal that a file has grown too large. Another program may not check the
    // results of its writes, so it gets the default action.
    const bool is_kept = now.sa_handler == SIG_IGN && !start.settings.blocked_signals && signal != SIGXFSZ;
    if (is_kept) continue;
    now = {};
    now.sa_handler = SIG_DFL;
    ::sigaction(signal, &now, nullptr);
  }
  check_call(start, ::sigprocmask(SIG_SETMASK, &start.mask, nullptr));
}

[[noreturn]] void become_program(ChildStart& start) {
  if (start.settings.ends_with_thread) {
    check_call(start, ::prctl(PR_SET_PDEATHSIG, SIGKILL));
    if (::getppid() != start.starter) ::_exit(127);  // the process that started the child has already ended
  }
  if (start.settings.has_own_group) check_call(start, ::setpgid(0, 0));
  arrange_files(start);
  arrange_signals(start);
  const auto become = start.settings.is_in_path ? &::execvp : &::execv;
  check_call(start, become(start.argv[0], start.argv));
  ::_exit(127);
}

// Blocks all signals. The child shares this process's memory, so no handler of this process may run in the child.
class AllSignalsBlocked {
 public:
  AllSignalsBlocked() {
    sigset_t all;
    sigfillset(&all);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~AllSignalsBlocked() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  AllSignalsBlocked(const AllSignalsBlocked&) = delete;
  AllSignalsBlocked& operator=(const AllSignalsBlocked&) = delete;
  const sigset_t& before() const { return before_; }

 private:
  sigset_t before_;
};

sigset_t mask_of(const SpawnSettings& settings, const sigset_t& own) {
  if (!settings.blocked_signals) return own;
  sigset_t mask;
  sigemptyset(&mask);
  for (const int signal : *settings.blocked_signals) sigaddset(&mask, signal);
  return mask;
}

[[gnu::noinline]] pid_t start_child(ChildStart start) {
  const pid_t pid = ::vfork();
  if (pid == 0) become_program(start);
  return pid;
}

}  // namespace

pid_t spawn_process(const std::vector<std::string>& arguments, const SpawnSettings& settings) {
  MULTUM_CHECK(!arguments.empty());
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) cannot_start(arguments[0], errno);
  const OpenFile failure(ends[0]);
  OpenFile low_end(ends[1]);
  int last = STDERR_FILENO;
  for (const auto& [ours, theirs] : settings.files) last = std::max(last, theirs);
  // The descriptor gets a number above all descriptors of the child.
  OpenFile failure_end(::fcntl(low_end.descriptor(), F_DUPFD_CLOEXEC, last + 1));
  if (!failure_end.is_open()) cannot_start(arguments[0], errno);
  pid_t pid = -1;
  int error = 0;
  {
    const AllSignalsBlocked blocked;
    pid = start_child(
        {settings, argv.data(), mask_of(settings, blocked.before()), failure_end.descriptor(), last, ::getpid()});
    error = errno;
  }
  if (pid < 0) cannot_start(arguments[0], error);
  { const OpenFile closed[] = {std::move(failure_end), std::move(low_end)}; }
  ssize_t count = 0;
  do count = ::read(failure.descriptor(), &error, sizeof(error));
  while (count < 0 && errno == EINTR);
  if (count != static_cast<ssize_t>(sizeof(error))) return pid;
  while (::waitpid(pid, nullptr, 0) < 0 && errno == EINTR) {
  }
  cannot_start(arguments[0], error);
}

}  // namespace multum
