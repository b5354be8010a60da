// SPDX-License-Identifier: Apache-2.0
// Reports progress of long calls and cancels them. Work is counted in units declared in advance. If a callback returns
// false, the next advance() throws Cancelled, and the destructors of the caller's objects clean up.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>

namespace multum {

struct ProgressEvent {
  std::string stage;          // the current work: "read", "fit level 3", "write"
  std::uint64_t units_done;   // finished units of all stages together
  std::uint64_t units_total;  // units declared by start(); 0 while unknown
};

class Progress {
 public:
  using Callback = std::function<bool(const ProgressEvent&)>;  // returns false to cancel

  explicit Progress(Callback callback) : callback_(std::move(callback)) {}

  /// Declares the amount of work. Only the outermost long call calls this function, and only once. If several long
  /// calls follow each other, the count starts at 0 for each of them.
  void start(std::uint64_t units_total);
  /// Names the next stage. Throws Cancelled if the callback returns false.
  void stage(const std::string& name);
  /// Counts finished units. Throws Cancelled if the callback returns false.
  void advance(std::uint64_t units);
  /// Counts the remaining work as done. This function never throws Cancelled, because a finished result cannot be
  /// cancelled.
  void finish();

 private:
  void report();
  Callback callback_;
  ProgressEvent event_{"", 0, 0};
};

// Call the functions above for an optional Progress. They do nothing if the pointer is null.
inline void progress_start(Progress* p, std::uint64_t units) {
  if (p != nullptr) p->start(units);
}
inline void progress_stage(Progress* p, const std::string& name) {
  if (p != nullptr) p->stage(name);
}
inline void progress_advance(Progress* p, std::uint64_t units) {
  if (p != nullptr) p->advance(units);
}
inline void progress_finish(Progress* p) {
  if (p != nullptr) p->finish();
}

/// Returns a Progress for one part of a longer call. The longer call counts its own units, so the returned object only
/// passes cancellation on. `progress` must outlive the returned object.
inline Progress cancel_only(Progress* progress) {
  return Progress([progress](const ProgressEvent&) {
    progress_advance(progress, 0);
    return true;
  });
}

/// Shows a progress bar on stderr if stderr is a terminal. Ctrl-C and SIGTERM cancel the work.
std::unique_ptr<Progress> make_terminal_progress(bool show_bar);

}  // namespace multum
