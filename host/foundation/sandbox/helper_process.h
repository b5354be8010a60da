// SPDX-License-Identifier: Apache-2.0
// Runs work in a child process if the work may crash, as libraries do on some broken files. Requests and answers are
// messages over a socket. Results are in shared memory. The child's memory and time are limited. If the child crashes,
// does not answer or uses too much memory, this process gets an exception.
//
//   this process                        the child (host/foundation/sandbox/helper_service.h)
//   ask("...")      -- socket, fd 3 -->  answer("...")
//   memory()        == memfd,  fd 4 ===  the child's results
//   its last words  <- memfd, fd 1, 2 -  output of libraries
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

/// Limits of one request. If the child needs more memory, its allocations fail or it is killed. If it needs more time,
/// it is killed. Time in which the child waits because other programs use the processors does not count. The processor
/// time of all its threads together is limited to time_max per core.
struct HelperLimits {
  std::uint64_t memory_max;  // writable bytes in total, without the shared memory
  std::chrono::milliseconds time_max;
};

/// Thrown if the child has ended. what() tells how it ended: "was terminated by signal 11 (Segmentation fault)".
class HelperEnded : public std::runtime_error {
 public:
  HelperEnded(const std::string& how, bool lacked_memory) : std::runtime_error(how), lacked_memory_(lacked_memory) {}
  /// Returns whether the machine, and not the request, is the likely cause. This is true if the child could not be
  /// loaded, or if the system killed it (for example because memory ran out). It is also true if a limit of this
  /// process (ulimit -v, -d) left the child less memory than HelperLimits allow.
  bool lacked_memory() const { return lacked_memory_; }

 private:
  bool lacked_memory_;
};

class HelperProcess {
 public:
  /// Starts the program. Throws Error(kEnvironment) if it cannot be started. The child has only the files listed above,
  /// does not receive Ctrl-C, and ends when this process ends in any way.
  explicit HelperProcess(const std::string& program);
  ~HelperProcess();
  HelperProcess(const HelperProcess&) = delete;
  HelperProcess& operator=(const HelperProcess&) = delete;

  const std::string& program() const { return program_; }
  pid_t pid() const { return pid_; }
  bool is_alive() const { return pid_ > 0; }
  SharedMemory& memory() { return memory_; }

  /// Returns the child's answer. Calls `while_waiting` a few times per second; if this function throws, the child is
  /// killed. Throws HelperEnded if the child has ended during this call or before it.
  std::string ask(std::string_view request, const HelperLimits& limits, const std::function<void()>& while_waiting);

 private:
  // Time of one request.
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
  std::uint64_t memory_max_ = 0;  // the current limit
  std::string received_;
  SharedMemory memory_;
};

}  // namespace multum
