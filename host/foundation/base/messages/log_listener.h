// SPDX-License-Identifier: Apache-2.0
// Delivers the log of one call to one listener, so that several calls in one process do not mix their logs. A thread
// has at most one listener. Threads that work for this thread use its listener too (with_own_log()).
#pragma once

#include <string>
#include <utility>

namespace multum {

class HeldWarnings;

enum class LogKind { kWarning, kInfo, kVerbose };

/// Receives lines of the log. Several threads that work for one call may call it at the same time.
class LogListener {
 public:
  virtual ~LogListener() = default;
  virtual void hear(LogKind kind, const std::string& line) = 0;
};

/// The receivers of a thread's log; both are null by default.
struct LogReceivers {
  LogListener* listener = nullptr;  // if null, lines go to show_log_line()
  HeldWarnings* held = nullptr;     // collects warnings instead (held_warnings.h)
};

/// Returns the receivers of this thread.
LogReceivers& log_receivers();

/// Gives this thread other receivers while the object exists.
class LogScope {
 public:
  explicit LogScope(const LogReceivers& receivers) : outer_(log_receivers()) { log_receivers() = receivers; }
  ~LogScope() { log_receivers() = outer_; }
  LogScope(const LogScope&) = delete;
  LogScope& operator=(const LogScope&) = delete;

 private:
  LogReceivers outer_;
};

/// Returns a function that runs `body` in another thread with the receivers of the calling thread. The caller must wait
/// for that thread before the receivers are destroyed.
template <typename Body>
auto with_own_log(Body body) {
  return [receivers = log_receivers(), body = std::move(body)]() mutable {
    const LogScope scope(receivers);
    return body();
  };
}

}  // namespace multum
