// SPDX-License-Identifier: Apache-2.0
// Runs a child that does what may end a process: it calls libraries that die on broken files. It is asked by messages
// over a socket, answers by messages and in memory that both see, and is held to memory and time. Its crash, its
// silence and its hunger are an exception here.
//
//   this process                        the child (host/foundation/sandbox/helper_service.h)
//   ask("...")      -- socket, fd 3 -->  answer("...")
//   memory()        == memfd,  fd 4 ===  what it writes there
//   its last words  <- memfd, fd 1, 2 -  what libraries print
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <stdexcept>
#include <string>
#include <string_view>

#include "host/foundation/sandbox/shared_memory.h"

namespace multum {

/// Limits of one request. Above the memory, the child's own allocations fail, and it is killed where they do not; above
/// the time it is killed: what passes while it is ready to run and other programs have the processors does not count.
/// The processor time of all its threads is limited to time_max a core.
struct HelperLimits {
  std::uint64_t memory_max;  // bytes that it may write to, all in all; those of the shared memory not counted
  std::chrono::milliseconds time_max;
};

/// The child is gone; what() says how: "was ended by signal 11 (Segmentation fault)".
class HelperEnded : public std::runtime_error {
 public:
  HelperEnded(const std::string& how, bool lacked_memory) : std::runtime_error(how), lacked_memory_(lacked_memory) {}
  /// Whether the machine, and not what it was asked for, is the likely reason: it could not be loaded, the system
  /// killed it, as it does where memory runs out, or it died where a limit of this process (ulimit -v, -d) leaves it
  /// less memory than HelperLimits allow.
  bool lacked_memory() const { return lacked_memory_; }

 private:
  bool lacked_memory_;
};

class HelperProcess {
 public:
  /// Throws Error(kEnvironment) when the program cannot be started. It has no other files than those above, hears no
  /// Ctrl-C, and ends when this process does, however that ends.
  explicit HelperProcess(const std::string& program);
  ~HelperProcess();
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;

  const std::string& program() const { return program_; }
  pid_t pid() const { return pid_; }
  bool is_alive() const { return pid_ > 0; }
  SharedMemory& memory() { return memory_; }

  /// The child's answer. `while_waiting` is called a few times a second; when it throws, the child is killed. Throws
  /// HelperEnded, now and whenever it is asked again.
  std::string ask(std::string_view request, const HelperLimits& limits, const std::function<void()>& while_waiting);

 private:
  // Of one request.
  struct Stopwatch {
    std::chrono::steady_clock::time_point looked;
    std::chrono::nanoseconds ran_before, spent;
    void look(pid_t pid);
  };

  void hold_to(const HelperLimits& limits);
  void send(std::string_view request);
  std::string receive(const HelperLimits& limits, const std::function<void()>& while_waiting);
  void check(const HelperLimits& limits, Stopwatch& watch);
  int kill_and_wait();
  int wait_for_end();
  [[noreturn]] void end(const std::string& why);
  [[noreturn]] void reap();

  std::string program_;
  pid_t pid_ = -1;
  int socket_ = -1;
  int last_words_ = -1;
  std::uint64_t memory_max_ = 0;  // that it is held to now
  std::string received_;
  SharedMemory memory_;
};

}  // namespace multum
